//! Mean of a light's texture as receivers see it without occluders.

use glam::{Vec2, Vec3};
use halflight_core::light::AreaLight;
use halflight_core::light_texture::PlacedTexture;
use halflight_core::scene::Scene;

use crate::samples::{LANES, geometry_terms};
use crate::simd::{Isa, Kernel, Lanes, Simd};
use crate::vector::Vector;

/// Number of grids, from the coarsest on, that are taken as a whole.
const UNIFORM: usize = 2;

/// Least distance of a receiver in sizes of a cell. The geometry term at a cell's centre is then within 2 % of its mean over the cell, and most of
/// that cancels in the ratio.
const DISTANCE: f32 = 4.0;

/// Cells of a light, a grid for each number of them.
pub struct SeenTexture {
    grids: Vec<Grid>,
    /// Corner and edges of the light, and the inverse squared lengths of the edges.
    frame: [Vec3; 3],
    normal: Vec3,
    two_sided: bool,
    mean: Vec3,
}

/// Centres of cells, world space, and mean factors of the radiance there, in whole blocks of [`LANES`].
struct Grid {
    /// Longer side of a cell, metres.
    size: f32,
    centres: [Vec<f32>; 3],
    rgb: [Vec<f32>; 3],
}

impl SeenTexture {
    /// Numbers of cells along a side of the light, of each grid: powers of 2 from the first to the last.
    pub const SIDES: [u16; 5] = [4, 8, 16, 32, 64];

    /// Cells of a light of a scene; none if it is uniform.
    pub fn of(scene: &Scene, light: usize) -> Option<Self> {
        let light = scene.lights.get(light)?;
        Some(Self::new(light, &scene.light_texture(light)?))
    }

    /// Mean factors of the radiance that a receiver with this normal sees.
    pub fn mean_seen(&self, origin: Vec3, normal: Vec3) -> Vec3 {
        self.seen_by(Isa::best(), origin, normal)
    }

    pub(crate) fn new(light: &AreaLight, texture: &PlacedTexture) -> Self {
        let frame = light.frame();
        let longest = frame.u.length().max(frame.v.length());
        let grid = |side: u16| {
            let cells = texture.cells(side, side);
            let centre = |index: usize| {
                let (column, row) = (index % usize::from(side), index / usize::from(side));
                light.point(Vec2::new(column as f32 + 0.5, row as f32 + 0.5) / f32::from(side))
            };
            let centres: Vec<Vec3> = (0..cells.len()).map(centre).collect();
            Grid {
                size: longest / f32::from(side),
                centres: [0, 1, 2].map(|axis| centres.iter().map(|centre| centre[axis]).collect()),
                rgb: [0, 1, 2].map(|channel| cells.iter().map(|cell| cell[channel]).collect()),
            }
        };
        Self {
            grids: Self::SIDES.map(grid).into_iter().collect(),
            frame: [frame.origin, frame.u, frame.v],
            normal: light.normal(),
            two_sided: light.two_sided,
            mean: texture.mean(),
        }
    }

    /// Computes the mean factors of the radiance that receivers with these normals see, as many as the shortest slice has.
    pub(crate) fn seen(&self, origins: &[Vec3], normals: &[Vec3], out: &mut [Vec3]) {
        let isa = Isa::best();
        for (out, (&origin, &normal)) in out.iter_mut().zip(origins.iter().zip(normals)) {
            *out = self.seen_by(isa, origin, normal);
        }
    }

    fn seen_by(&self, isa: Isa, origin: Vec3, normal: Vec3) -> Vec3 {
        let side = self.normal.dot(origin - self.frame[0]);
        if normal == Vec3::ZERO || side == 0.0 || side < 0.0 && !self.two_sided {
            return self.mean;
        }
        let near = self.distance(origin);
        let facing = if side < 0.0 { -self.normal } else { self.normal };
        let found = match self.grids[..UNIFORM].iter().find(|grid| grid.size * DISTANCE <= near) {
            Some(grid) => isa.run(Mean { grid, origin, normal, facing }),
            None => self.seen_from_nearby(origin, normal, facing),
        };
        found.unwrap_or(self.mean)
    }

    /// Mean over cells that are the finer, the nearer they are; none where all geometry terms are 0.
    fn seen_from_nearby(&self, origin: Vec3, normal: Vec3, facing: Vec3) -> Option<Vec3> {
        let (mut sum, mut all) = (Vec3::ZERO, 0.0);
        let mut waiting = [(0u8, 0u16, 0u16); 64];
        let first = usize::from(Self::SIDES[0]) * usize::from(Self::SIDES[0]);
        for cell in 0..first {
            let side = usize::from(Self::SIDES[0]);
            waiting[0] = (0, (cell % side) as u16, (cell / side) as u16);
            let mut count = 1;
            while count > 0 {
                count -= 1;
                let (level, column, row) = waiting[count];
                let grid = &self.grids[usize::from(level)];
                let index =
                    usize::from(row) * usize::from(Self::SIDES[usize::from(level)]) + usize::from(column);
                let [centre, rgb] =
                    [&grid.centres, &grid.rgb].map(|of| Vec3::from_array([0, 1, 2].map(|at| of[at][index])));
                let to = centre - origin;
                let squared = to.length_squared();
                let fine = usize::from(level) + 1 == Self::SIDES.len();
                if !fine && grid.size * grid.size * (DISTANCE * DISTANCE) > squared {
                    for (x, y) in [(1, 1), (0, 1), (1, 0), (0, 0)] {
                        waiting[count] = (level + 1, 2 * column + x, 2 * row + y);
                        count += 1;
                    }
                } else if squared > 0.0 {
                    let heights = to.dot(normal).max(0.0) * to.dot(-facing).max(0.0);
                    let term = heights / (squared * squared) * (grid.size * grid.size);
                    sum += rgb * term;
                    all += term;
                }
            }
        }
        (all > 0.0).then(|| sum / all)
    }

    /// Distance to about the nearest point of the light: exact for rectangles.
    fn distance(&self, origin: Vec3) -> f32 {
        let [corner, u, v] = self.frame;
        let along = |edge: Vec3| ((origin - corner).dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
        (corner + u * along(u) + v * along(v)).distance(origin)
    }
}

/// Mean over the cells of a grid by their geometry terms; none where all are 0.
struct Mean<'a> {
    grid: &'a Grid,
    origin: Vec3,
    normal: Vec3,
    facing: Vec3,
}

impl Kernel for Mean<'_> {
    type Output = Option<Vec3>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Option<Vec3> {
        let Self { grid, origin, normal, facing } = self;
        // Lane sums are kept apart to the end, so that every instruction set adds in the same order.
        let mut sums = [[S::Wide::splat(0.0); 2]; 4];
        let origin = Vector::splat(origin);
        for first in (0..grid.centres[0].len()).step_by(LANES) {
            for (part, at) in (0..LANES).step_by(S::Wide::WIDTH).enumerate() {
                let at = first + at;
                let [x, y, z] = [0, 1, 2].map(|axis| S::Wide::load(&grid.centres[axis][at..]));
                let terms = geometry_terms::<S::Wide>(Vector { x, y, z }.sub(origin), normal, facing);
                sums[3][part] = sums[3][part].add(terms);
                for (sum, channel) in sums.iter_mut().zip(&grid.rgb) {
                    sum[part] = sum[part].add(terms.mul(S::Wide::load(&channel[at..])));
                }
            }
        }
        let [red, green, blue, all]: [f32; 4] = sums.map(|sum| {
            let mut lanes = [0.0; LANES];
            for (part, at) in (0..LANES).step_by(S::Wide::WIDTH).enumerate() {
                sum[part].store(&mut lanes[at..]);
            }
            lanes.iter().sum()
        });
        (all > 0.0).then(|| Vec3::new(red, green, blue) / all)
    }
}
