//! Poisson-disk points on the surfaces of a mesh (Koa16 §3.2), and groups of them.
//!
//! Candidates are spread over all surfaces by area (a Halton sequence over the cumulative area of the triangles). In their order, each becomes a
//! point unless one lies nearer than the disk's radius on a surface of about the same direction. Then every candidate goes to the nearest point:
//! the part of the candidates that a point gets is the part of the surface that it stands for. Groups of points are made of the points as points are
//! made of candidates, by a larger disk.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::sync::Arc;

use glam::{DVec2, DVec3, Vec3};
use halflight_core::gbuffer::receiver_origin;
use halflight_core::scene::Mesh;
use halflight_core::smooth::SmoothTriangle;
use rayon::prelude::*;

use crate::gbuffer::diffuse_albedo;

/// Candidates for each point.
const CANDIDATES: usize = 8;

/// Points of a group, about.
const GROUP: f64 = 8.0;

/// Points that fit on an area, times the square of the radius and over the area: about what that many candidates come to.
const DENSITY: f64 = 0.6;

/// Cosine between normals, on either side, above which surfaces have one direction.
const ALIKE: f32 = 0.5;

/// Attempts to come near the number of points that was asked for; on surfaces that are finer than the radius a disk holds several.
const ATTEMPTS: usize = 4;

/// Largest growth of a triangle, beside that of the whole mesh, that points on it follow.
const MOST_GROWTH: f64 = 4.0;

/// Place on a triangle: its index and the weights of its second and third corner. It stays there when the mesh deforms.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    triangle: u32,
    second: f32,
    third: f32,
}

/// Point of a surface at which light is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point {
    /// World space, on the surface.
    pub(crate) position: Vec3,
    /// Geometric unit normal, by the winding of the triangle; surfaces have two sides.
    pub(crate) normal: Vec3,
    /// Area that the point stands for, square metres.
    pub(crate) area: f32,
    /// Starts of its shadow rays, in front of the surface and behind it.
    pub(crate) origins: [Vec3; 2],
    /// Unit shading normal, in front of the surface.
    pub(crate) shading: Vec3,
    /// Linear RGB albedo, of diffuse reflection.
    pub(crate) albedo: Vec3,
    /// True if the front lies on the other side than that of the group's first point.
    pub(crate) turned: bool,
}

/// Points of a mesh, group by group in the order of a space-filling curve.
#[derive(Debug, Default)]
pub(crate) struct Points {
    places: Vec<Place>,
    /// Area of each point and of its triangle when the places were chosen, square metres.
    areas: Vec<(f64, f64)>,
    pub(crate) points: Vec<Point>,
    /// Points of group `i` are `groups[i]..groups[i + 1]`.
    pub(crate) groups: Vec<u32>,
    /// Area of all triangles, square metres, and least distance of points on a surface, metres, when the places were chosen.
    placed: (f64, f64),
    /// Least distance of points on a surface, about, metres.
    pub(crate) radius: f32,
    mesh: Option<Arc<Mesh>>,
    rest: Option<Arc<Mesh>>,
    count: usize,
}

impl Points {
    /// Places about `count` points on the surfaces of `rest`, the mesh before its vertices moved, and moves them to where the same triangles of `mesh` are.
    /// Returns true if there was anything to do.
    pub(crate) fn follow(&mut self, mesh: &Arc<Mesh>, rest: &Arc<Mesh>, count: usize) -> bool {
        let same = |held: &Option<Arc<Mesh>>, mesh| held.as_ref().is_some_and(|held| Arc::ptr_eq(held, mesh));
        let placed = self.count == count && same(&self.rest, rest);
        if placed && same(&self.mesh, mesh) {
            return false;
        }
        if !placed {
            self.place(rest, count);
        }
        (self.mesh, self.rest, self.count) = (Some(Arc::clone(mesh)), Some(Arc::clone(rest)), count);
        self.locate(mesh);
        true
    }

    /// Memory held, bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.places.capacity() * size_of::<Place>()
            + self.areas.capacity() * size_of::<(f64, f64)>()
            + self.points.capacity() * size_of::<Point>()
            + self.groups.capacity() * 4
    }

    /// Chooses places on the triangles.
    fn place(&mut self, mesh: &Mesh, count: usize) {
        *self = Self::default();
        let cumulative: Vec<f64> = (0..mesh.triangle_count())
            .scan(0.0, |sum, triangle| {
                *sum += area(mesh, triangle);
                Some(*sum)
            })
            .collect();
        let total = cumulative.last().copied().unwrap_or(0.0);
        if count == 0 || total.is_nan() || total <= 0.0 {
            self.groups.push(0);
            return;
        }
        let number = count * CANDIDATES;
        let places: Vec<Place> = (0..number)
            .map(|index| candidate(&cumulative, total, index))
            .filter(|place| is_solid(mesh, place))
            .collect();
        let surfaces: Vec<(Vec3, Vec3)> =
            places.par_iter().with_min_len(1024).map(|place| surface(mesh, place)).collect();
        let share = total / number as f64;
        // Holes of alpha masks are no surface.
        let mut radius = (DENSITY * share * places.len() as f64 / count as f64).sqrt();
        let mut owners = Vec::new();
        for attempt in 0..ATTEMPTS {
            owners = disks(&surfaces, radius as f32);
            let points = (0..owners.len()).filter(|&index| owners[index] as usize == index).count();
            if attempt + 1 == ATTEMPTS || 5 * points >= 4 * count.min(places.len()) {
                break;
            }
            radius *= (points as f64 / count as f64).sqrt();
        }
        self.placed = (total, radius);
        let mut areas = vec![0.0; places.len()];
        owners.iter().for_each(|&owner| areas[owner as usize] += share);
        let points: Vec<usize> = (0..places.len()).filter(|&index| owners[index] as usize == index).collect();
        let own: Vec<(Vec3, Vec3)> = points.iter().map(|&point| surfaces[point]).collect();
        let groups = disks(&own, (radius * GROUP.sqrt()) as f32);
        for (point, starts) in in_groups(&own, &groups) {
            if starts {
                self.groups.push(self.places.len() as u32);
            }
            let place = places[points[point]];
            self.places.push(place);
            self.areas.push((areas[points[point]], area(mesh, place.triangle as usize)));
        }
        self.groups.push(self.places.len() as u32);
    }

    /// Computes where the places lie now.
    fn locate(&mut self, mesh: &Mesh) {
        let Self { places, areas, points, groups, placed, .. } = self;
        let total: f64 = (0..mesh.triangle_count()).map(|triangle| area(mesh, triangle)).sum();
        let growth = if placed.0 > 0.0 { total / placed.0 } else { 1.0 };
        self.radius = (placed.1 * growth.sqrt()) as f32;
        points.clear();
        points.extend(places.iter().zip(areas).map(|(place, &mut (share, before))| {
            // A triangle that was too small for its candidates may have one that stands for more than it.
            let most = MOST_GROWTH * growth.max(1.0);
            let grown = if before > 0.0 { area(mesh, place.triangle as usize) / before } else { 1.0 };
            let grown = grown.min(most);
            point(mesh, place, (share * grown) as f32)
        }));
        for group in groups.windows(2) {
            let group = &mut points[group[0] as usize..group[1] as usize];
            let Some(front) = group.first().map(|first| first.normal) else { continue };
            group.iter_mut().for_each(|point| point.turned = point.normal.dot(front) < 0.0);
        }
    }
}

/// Order of points, group by group along a space-filling curve; true for the first of each group, which is the one that owns it.
fn in_groups(surfaces: &[(Vec3, Vec3)], groups: &[u32]) -> Vec<(usize, bool)> {
    let low = surfaces.iter().fold(Vec3::INFINITY, |low, surface| low.min(surface.0));
    let high = surfaces.iter().fold(Vec3::NEG_INFINITY, |high, surface| high.max(surface.0));
    let scale = 1023.0 / (high - low).max_element().max(f32::MIN_POSITIVE);
    let code = |index: usize| morton((surfaces[index].0 - low) * scale);
    let mut order: Vec<usize> = (0..surfaces.len()).collect();
    order.sort_by_key(|&index| {
        let owner = groups[index] as usize;
        (code(owner), owner, index != owner, code(index), index)
    });
    order.into_iter().map(|index| (index, groups[index] as usize == index)).collect()
}

/// Area of a triangle, square metres.
fn area(mesh: &Mesh, triangle: usize) -> f64 {
    let [a, b, c] = mesh.corners(triangle).map(Vec3::as_dvec3);
    0.5 * (b - a).cross(c - a).length()
}

/// Candidate `index`: the van der Corput sequence in base 2 goes over the cumulative area, which gives the triangle and one coordinate in it; that
/// in base 3 is the other.
fn candidate(cumulative: &[f64], total: f64, index: usize) -> Place {
    let along = f64::from((index as u32).reverse_bits()) / f64::from(u32::MAX) * total;
    let triangle = cumulative.partition_point(|&sum| sum <= along).min(cumulative.len() - 1);
    let start = if triangle == 0 { 0.0 } else { cumulative[triangle - 1] };
    let inside = (along - start) / (cumulative[triangle] - start).max(f64::MIN_POSITIVE);
    let (u, v) = (inside.clamp(0.0, 1.0).sqrt(), radical_inverse_3(index as u32));
    Place { triangle: triangle as u32, second: (u * (1.0 - v)) as f32, third: (u * v) as f32 }
}

fn radical_inverse_3(mut index: u32) -> f64 {
    let (mut value, mut digit) = (0.0, 1.0 / 3.0);
    while index > 0 {
        value += f64::from(index % 3) * digit;
        index /= 3;
        digit /= 3.0;
    }
    value
}

fn is_solid(mesh: &Mesh, place: &Place) -> bool {
    let triangle = place.triangle as usize;
    let Some(mask) = mesh.alpha_mask(triangle) else { return true };
    let [a, b, c] = mesh.triangles[triangle].map(|vertex| mesh.uvs[vertex as usize].as_dvec2());
    let uv: DVec2 = a + (b - a) * f64::from(place.second) + (c - a) * f64::from(place.third);
    mask.is_solid(uv)
}

fn exactly(mesh: &Mesh, place: &Place) -> (DVec3, Vec3) {
    let [a, b, c] = mesh.corners(place.triangle as usize).map(Vec3::as_dvec3);
    let point = a + (b - a) * f64::from(place.second) + (c - a) * f64::from(place.third);
    (point, (b - a).cross(c - a).normalize_or_zero().as_vec3())
}

/// Position and geometric normal of a place.
fn surface(mesh: &Mesh, place: &Place) -> (Vec3, Vec3) {
    let (point, normal) = exactly(mesh, place);
    (point.as_vec3(), normal)
}

fn point(mesh: &Mesh, place: &Place, area: f32) -> Point {
    let triangle = place.triangle as usize;
    let (flat, normal) = exactly(mesh, place);
    let corners = mesh.corners(triangle);
    let extent = corners.iter().fold(Vec3::NEG_INFINITY, |high, &corner| high.max(corner))
        - corners.iter().fold(Vec3::INFINITY, |low, &corner| low.min(corner));
    let (mut front, mut shading) = (flat, normal);
    if let Some(smooth) = SmoothTriangle::new(mesh, triangle, normal) {
        let weights = [1.0 - place.second - place.third, place.second, place.third];
        (front, shading) = smooth.surface(corners, weights, flat);
    }
    let extent = extent.max_element();
    Point {
        position: flat.as_vec3(),
        normal,
        area,
        origins: [receiver_origin(front, normal, extent), receiver_origin(flat, -normal, extent)],
        shading,
        albedo: diffuse_albedo(mesh, place.triangle, place.second, place.third),
        turned: false,
    }
}

/// Surfaces by cells of a grid. Cells that are 2²¹ apart are one, which costs time alone.
type Cells = HashMap<u64, Vec<u32>, BuildHasherDefault<Mixed>>;

/// Hash of cells: their number times an odd one.
#[derive(Default)]
struct Mixed(u64);

impl Hasher for Mixed {
    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|&byte| self.write_u64(self.0 ^ u64::from(byte)));
    }

    fn write_u64(&mut self, cell: u64) {
        let product = cell.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.0 = product ^ (product >> 32);
    }

    fn finish(&self) -> u64 {
        self.0
    }
}

fn cell_number(cell: glam::IVec3) -> u64 {
    let part = |value: i32| u64::from(value as u32 & 0x1f_ffff);
    part(cell.x) | part(cell.y) << 21 | part(cell.z) << 42
}

/// Owner of each surface: itself if no owner before it lies within the radius and has about its direction, otherwise the nearest such one.
fn disks(surfaces: &[(Vec3, Vec3)], radius: f32) -> Vec<u32> {
    let inverse = 1.0 / radius.max(f32::MIN_POSITIVE);
    let cell = |position: Vec3| (position * inverse).floor().as_ivec3();
    let mut grid = Cells::default();
    let nearest = |grid: &Cells, (position, normal): (Vec3, Vec3)| {
        let centre = cell(position);
        let mut best = (radius * radius, u32::MAX);
        for at in 0..27 {
            let step = glam::IVec3::new(at % 3 - 1, at / 3 % 3 - 1, at / 9 - 1);
            let key = cell_number(centre.saturating_add(step));
            for &index in grid.get(&key).map_or(&[][..], Vec::as_slice) {
                let other = surfaces[index as usize];
                let apart = other.0.distance_squared(position);
                if (apart, index) < best && other.1.dot(normal).abs() > ALIKE {
                    best = (apart, index);
                }
            }
        }
        (best.1 != u32::MAX).then_some(best.1)
    };
    let mut owners = vec![u32::MAX; surfaces.len()];
    for (index, &surface) in surfaces.iter().enumerate() {
        if nearest(&grid, surface).is_none() {
            owners[index] = index as u32;
            grid.entry(cell_number(cell(surface.0))).or_default().push(index as u32);
        }
    }
    owners.par_iter_mut().zip(surfaces).enumerate().with_min_len(256).for_each(
        |(index, (owner, &surface))| {
            if *owner == u32::MAX {
                *owner = nearest(&grid, surface).unwrap_or(index as u32);
            }
        },
    );
    owners
}

/// Index on the Morton curve of a place in a cube of side 1023.
fn morton(place: Vec3) -> u32 {
    let spread = |value: f32| {
        let mut bits = (value as u32).min(1023);
        bits = (bits | bits << 16) & 0x0300_00ff;
        bits = (bits | bits << 8) & 0x0300_f00f;
        bits = (bits | bits << 4) & 0x030c_30c3;
        (bits | bits << 2) & 0x0924_9249
    };
    spread(place.x) | spread(place.y) << 1 | spread(place.z) << 2
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;

    /// A square floor of 4 × 4 m in two triangles and a wall of 4 × 1 m.
    fn room() -> Arc<Mesh> {
        let positions = vec![
            Vec3::ZERO,
            Vec3::new(0.0, 0.0, 4.0),
            Vec3::new(4.0, 0.0, 4.0),
            Vec3::new(4.0, 0.0, 0.0),
            Vec3::new(0.0, 1.0, 0.0),
            Vec3::new(4.0, 1.0, 0.0),
        ];
        let triangles = vec![[0, 1, 2], [0, 2, 3], [0, 3, 5], [0, 5, 4]];
        let mesh = Mesh {
            uvs: vec![Vec2::ZERO; positions.len()],
            positions,
            triangles,
            material_ids: vec![0; 4],
            materials: vec![halflight_core::scene::Material::default()],
            ..Mesh::default()
        };
        Arc::new(mesh)
    }

    fn placed(count: usize) -> Points {
        let mut points = Points::default();
        let room = room();
        assert!(points.follow(&room, &room, count));
        points
    }

    #[test]
    fn points_keep_their_distance_and_cover_the_area() {
        for count in [10, 100, 1000] {
            let Points { points, groups, .. } = placed(count);
            assert!((0.7..1.4).contains(&(points.len() as f32 / count as f32)), "{count}: {}", points.len());
            let total: f32 = points.iter().map(|point| point.area).sum();
            assert!((total - 20.0).abs() < 1e-3, "{total}");
            let floor: f32 = points.iter().filter(|p| p.normal.y.abs() > 0.9).map(|p| p.area).sum();
            assert!((floor - 16.0).abs() < 40.0 / (8.0 * count as f32), "{count}: {floor}");
            let least = (DENSITY * 20.0 / count as f64).sqrt() as f32 * 0.999;
            for (index, a) in points.iter().enumerate() {
                for b in &points[..index] {
                    let apart = a.position.distance(b.position);
                    assert!(apart > least || a.normal.dot(b.normal).abs() < ALIKE, "{count}");
                }
            }
            // Groups are runs of points that lie together on one surface.
            assert_eq!((groups[0], groups[groups.len() - 1]), (0, points.len() as u32));
            for group in groups.windows(2) {
                let group = &points[group[0] as usize..group[1] as usize];
                for point in group {
                    assert!(point.position.distance(group[0].position) <= least * 2.9);
                    assert!(point.normal.dot(group[0].normal) > 0.9 && !point.turned);
                }
            }
            let mean = points.len() as f32 / (groups.len() - 1) as f32;
            assert!(count < 100 || (4.0..12.0).contains(&mean), "{count}: {mean}");
        }
    }

    #[test]
    fn points_stay_on_their_triangles_when_the_mesh_moves() {
        let rest = room();
        let mut points = Points::default();
        points.follow(&rest, &rest, 100);
        let (before, radius) = (points.points.clone(), points.radius);
        assert!(!points.follow(&rest, &rest, 100));
        let mut mesh = Mesh::clone(&rest);
        mesh.positions.iter_mut().for_each(|position| *position = *position * 2.0 + Vec3::X);
        let moved = Arc::new(mesh);
        assert!(points.follow(&moved, &rest, 100));
        assert_eq!(points.points.len(), before.len());
        assert!((points.radius / radius - 2.0).abs() < 1e-3);
        for (after, before) in points.points.iter().zip(&before) {
            let expected = before.position * 2.0 + Vec3::X;
            assert!(after.position.distance(expected) < 1e-5);
            assert!((after.area / before.area - 4.0).abs() < 1e-3);
        }
        // Earlier meshes do not matter.
        let mut alone = Points::default();
        alone.follow(&moved, &rest, 100);
        assert_eq!(alone.points, points.points);
        // Another mesh: other points.
        let mut mesh = Mesh::clone(&moved);
        mesh.triangles.truncate(2);
        mesh.material_ids.truncate(2);
        let other = Arc::new(mesh);
        assert!(points.follow(&other, &other, 100));
        assert!(points.points.iter().all(|point| point.normal.y.abs() > 0.9));
    }

    #[test]
    fn nothing_has_no_points() {
        let mesh = Arc::new(Mesh::default());
        let mut points = Points::default();
        points.follow(&mesh, &mesh, 100);
        assert!(points.points.is_empty() && points.groups == [0]);
        assert!(placed(0).points.is_empty());
    }
}
