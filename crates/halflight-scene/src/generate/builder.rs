//! The mesh builder that all generators share.

use glam::{Vec2, Vec3};
use halflight_core::scene::{Material, Mesh};

/// Collects triangles; normals come at the end, smooth within each sheet and sharp between sheets.
///
/// Materials are numbers into the palette that [`Builder::finish`] is given.
#[derive(Clone, Default)]
pub(super) struct Builder {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    material_ids: Vec<u32>,
    material: u32,
}

impl Builder {
    pub(super) fn new() -> Self {
        Self::default()
    }

    /// Sets the material of everything added from here on; returns the one before.
    pub(super) fn paint(&mut self, material: u32) -> u32 {
        std::mem::replace(&mut self.material, material)
    }

    /// Gives everything so far one material.
    pub(super) fn repaint(&mut self, material: u32) {
        self.material_ids.fill(material);
    }

    /// A curved surface of `rows × columns` quads through `point(row, column)`.
    ///
    /// Seen from its front, rows go up and columns to the right. Quads that collapse to a line or a point are
    /// left out.
    pub(super) fn sheet(&mut self, rows: usize, columns: usize, point: impl Fn(usize, usize) -> Vec3) {
        self.grid(rows, columns, columns + 1, point);
    }

    /// Like [`Builder::sheet`], with the last column joined to the first.
    pub(super) fn ring(&mut self, rows: usize, columns: usize, point: impl Fn(usize, usize) -> Vec3) {
        self.grid(rows, columns, columns, point);
    }

    fn grid(&mut self, rows: usize, columns: usize, stride: usize, point: impl Fn(usize, usize) -> Vec3) {
        let first = self.positions.len();
        for row in 0..=rows {
            self.positions.extend((0..stride).map(|column| point(row, column)));
        }
        let index = |row, column| (first + row * stride + column % stride) as u32;
        for row in 0..rows {
            for column in 0..columns {
                let (a, b) = (index(row, column), index(row, column + 1));
                let (c, d) = (index(row + 1, column + 1), index(row + 1, column));
                self.triangle([a, b, c]);
                self.triangle([a, c, d]);
            }
        }
    }

    fn triangle(&mut self, corners: [u32; 3]) {
        let [a, b, c] = corners.map(|corner| self.positions[corner as usize]);
        let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
        // Collapsed quads leave triangles of rounding-error width: far below the thinnest strip any generator
        // makes.
        if (b - a).cross(c - a).length() > 1e-5 * longest {
            self.triangles.push(corners);
            self.material_ids.push(self.material);
        }
    }

    /// A flat quad, counter-clockwise seen from its front.
    pub(super) fn quad(&mut self, corners: [Vec3; 4]) {
        let [a, b, c, d] = corners;
        self.sheet(1, 1, |row, column| [[a, b], [d, c]][row][column]);
    }

    /// A square floor at y = 0 around the origin, `size` metres wide, in `cells × cells` quads.
    pub(super) fn floor(&mut self, size: f32, cells: usize) {
        let at = |i: usize| (i as f32 / cells as f32 - 0.5) * size;
        self.sheet(cells, cells, |row, column| Vec3::new(at(column), 0.0, -at(row)));
    }

    /// An axis-aligned box.
    pub(super) fn cuboid(&mut self, low: Vec3, high: Vec3) {
        self.hexahedron(|i| {
            let pick = |axis: usize| if i >> axis & 1 == 1 { high[axis] } else { low[axis] };
            Vec3::new(pick(0), pick(1), pick(2))
        });
    }

    /// A solid with six flat faces; bits 0, 1 and 2 of a corner's number say whether it is at the far end of
    /// three right-handed directions.
    pub(super) fn hexahedron(&mut self, corner: impl Fn(usize) -> Vec3) {
        for face in [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]] {
            self.quad(face.map(&corner));
        }
    }

    /// A box by the middle of its bottom face and its size.
    pub(super) fn block(&mut self, foot: Vec3, size: Vec3) {
        let half = Vec3::new(size.x / 2.0, 0.0, size.z / 2.0);
        self.cuboid(foot - half, foot + half + Vec3::Y * size.y);
    }

    /// Adds a copy of `part` with every vertex transformed by `map`, which must not mirror.
    pub(super) fn place(&mut self, part: &Self, map: impl Fn(Vec3) -> Vec3) {
        let first = self.positions.len() as u32;
        self.positions.extend(part.positions.iter().map(|&p| map(p)));
        self.triangles.extend(part.triangles.iter().map(|t| t.map(|vertex| vertex + first)));
        self.material_ids.extend_from_slice(&part.material_ids);
    }

    /// Number of triangles so far.
    pub(super) fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// The mesh, with the materials' albedos.
    pub(super) fn finish(self, palette: &[[f32; 3]]) -> Mesh {
        let mut sums = vec![Vec3::ZERO; self.positions.len()];
        for &triangle in &self.triangles {
            let [a, b, c] = triangle.map(|vertex| self.positions[vertex as usize]);
            // Not normalised: weighted by area.
            let normal = (b - a).cross(c - a);
            for vertex in triangle {
                sums[vertex as usize] += normal;
            }
        }
        Mesh {
            uvs: vec![Vec2::ZERO; self.positions.len()],
            // The fallback is for the corners of collapsed quads, which no triangle uses.
            normals: sums.into_iter().map(|sum| sum.normalize_or(Vec3::Y)).collect(),
            positions: self.positions,
            triangles: self.triangles,
            material_ids: self.material_ids,
            materials: palette
                .iter()
                .map(|&albedo| Material { albedo: Vec3::from_array(albedo), ..Material::default() })
                .collect(),
            ..Mesh::default()
        }
    }
}
