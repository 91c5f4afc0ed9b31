//! Triangle corners by position.

use std::hash::{BuildHasher, RandomState};

use glam::Vec3;
use halflight_core::hash::fold;
use halflight_core::scene::Mesh;

/// Triangle corners at every point. Vertices with equal positions are one point: seams of texture coordinates
/// or materials are not creases.
pub(super) struct Incidence {
    /// Start in `corners` of each point's corners; one entry more than points.
    starts: Vec<u32>,
    /// Corners, as three times the triangle, plus 0, 1 or 2.
    corners: Vec<u32>,
}

impl Incidence {
    pub(super) fn new(mesh: &Mesh) -> Self {
        let (point_of, points) = weld(&mesh.positions);
        let point = |vertex: u32| point_of[vertex as usize] as usize;
        let vertices = mesh.triangles.as_flattened();
        let mut starts = vec![0; points + 1];
        for &vertex in vertices {
            starts[point(vertex)] += 1;
        }
        // Ends first; each inserted corner moves its point's end down towards its start.
        let mut end = 0;
        for count in &mut starts {
            end += *count;
            *count = end;
        }
        let mut corners = vec![0; vertices.len()];
        for (corner, &vertex) in vertices.iter().enumerate().rev() {
            let slot = &mut starts[point(vertex)];
            *slot -= 1;
            corners[*slot as usize] = corner as u32;
        }
        Self { starts, corners }
    }

    /// Number of points.
    pub(super) fn points(&self) -> usize {
        self.starts.len() - 1
    }

    /// Corners at a point, in order.
    pub(super) fn of(&self, point: usize) -> &[u32] {
        &self.corners[self.starts[point] as usize..self.starts[point + 1] as usize]
    }
}

/// Point of every vertex, and the number of points, by a hash table of positions.
fn weld(positions: &[Vec3]) -> (Vec<u32>, usize) {
    const FREE: u32 = u32::MAX;
    // The result does not depend on the seed, which protects against files whose hashes all collide.
    let seed = RandomState::new().hash_one(0) as u32;
    let mut table = vec![FREE; (2 * positions.len()).next_power_of_two()];
    let mask = table.len() - 1;
    let mut point_of: Vec<u32> = Vec::with_capacity(positions.len());
    let mut points = 0;
    for (vertex, &position) in positions.iter().enumerate() {
        // Adding zero turns -0 into 0, an equal position.
        let hash = (position + 0.0).to_array().map(f32::to_bits).into_iter().fold(seed, fold);
        let mut place = hash as usize & mask;
        while table[place] != FREE && positions[table[place] as usize] != position {
            place = (place + 1) & mask;
        }
        if table[place] == FREE {
            table[place] = vertex as u32;
            point_of.push(points);
            points += 1;
        } else {
            point_of.push(point_of[table[place] as usize]);
        }
    }
    (point_of, points as usize)
}
