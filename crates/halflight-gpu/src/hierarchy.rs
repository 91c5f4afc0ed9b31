//! The BVH of shadow rays: obvhs's compressed wide BVH, built once and refitted where vertices move.

use std::time::Duration;

use glam::{DVec3, Vec3};
use halflight_core::scene::Mesh;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh;
use obvhs::cwbvh::node::CwBvhNode;

use crate::crowds::Crowds;
use crate::error::GpuError;

/// Levels of a BVH that shaders can traverse: `STACK` in `shaders/visibility/traversal.wgsl`.
const STACK: usize = 32;

/// Steps of a node's box: bounds of its children are bytes.
const STEPS: f64 = 255.0;

/// Lowest and highest coordinates.
type Bounds = (Vec3, Vec3);

/// Bounds of nothing.
const NONE: Bounds = (Vec3::INFINITY, Vec3::NEG_INFINITY);

/// A BVH over triangles of a mesh, whose leaves are places in an order of these.
#[derive(Debug)]
pub(crate) struct Hierarchy {
    wide: CwBvh,
}

impl Hierarchy {
    /// Builds the BVH over some triangles of a valid mesh.
    ///
    /// # Errors
    /// The BVH is deeper than shaders can traverse.
    pub(crate) fn build(mesh: &Mesh, triangles: &[u32]) -> Result<Self, GpuError> {
        if triangles.is_empty() {
            return Ok(Self { wide: CwBvh::default() });
        }
        let (crowds, padding) = (Crowds::of(mesh), padding(mesh));
        let boxes: Vec<Aabb> = triangles
            .iter()
            .map(|&triangle| {
                let (low, high) = crowds.bounds(triangle as usize);
                Aabb::new((low - padding).into(), (high + padding).into())
            })
            .collect();
        let mut wide = build_cwbvh(&boxes, BvhBuildParams::medium_build(), &mut Duration::default());
        wide.primitive_indices.iter_mut().for_each(|index| *index = triangles[*index as usize]);
        let depth = depth(&wide);
        if depth > STACK {
            return Err(GpuError::TooDeep { depth, limit: STACK });
        }
        Ok(Self { wide })
    }

    /// Nodes, as shaders read them.
    pub(crate) fn nodes(&self) -> &[CwBvhNode] {
        &self.wide.nodes
    }

    /// Triangles of the mesh by their place in the leaves.
    pub(crate) fn order(&self) -> &[u32] {
        &self.wide.primitive_indices
    }

    /// Fits the boxes to the same triangles in other places; the tree stays.
    pub(crate) fn refit(&mut self, mesh: &Mesh) {
        let padding = padding(mesh);
        let CwBvh { nodes, primitive_indices, .. } = &mut self.wide;
        let mut around = vec![NONE; nodes.len()];
        // Children come after their parents.
        for index in (0..nodes.len()).rev() {
            let node = &mut nodes[index];
            let children: [Bounds; 8] = std::array::from_fn(|child| {
                if node.is_child_empty(child) {
                    return NONE;
                }
                if !node.is_leaf(child) {
                    return around[node.child_node_index(child) as usize];
                }
                let (first, count) = node.child_primitives(child);
                let triangles = &primitive_indices[first as usize..(first + count) as usize];
                let corners = triangles.iter().flat_map(|&triangle| mesh.corners(triangle as usize));
                let (low, high) = corners.fold(NONE, |(low, high), p| (low.min(p), high.max(p)));
                (low - padding, high + padding)
            });
            around[index] =
                children.iter().fold(NONE, |(low, high), child| (low.min(child.0), high.max(child.1)));
            set_bounds(node, around[index], &children);
        }
    }
}

/// Returns how far boxes reach beyond their triangles. As on the CPU: box tests are wrong by a few units in the last place of
/// distances inside the scene, and of the boxes' own coordinates.
fn padding(mesh: &Mesh) -> f32 {
    let (low, high) = mesh.bounds().unwrap_or_default();
    let largest = low.abs().max(high.abs()).max_element();
    ((high - low).length() * 2f32.powi(-17)).max(largest * 2f32.powi(-21))
}

/// Rounds the boxes of a node's children outwards to steps of powers of two from the node's lowest corner.
fn set_bounds(node: &mut CwBvhNode, (low, high): Bounds, children: &[Bounds; 8]) {
    let origin = low.as_dvec3();
    let step = (high.as_dvec3() - origin).to_array().map(|size| {
        let at_least = (size / STEPS).max(1e-30) as f32;
        // Rounding to single precision may have been down.
        let exponent = (at_least.to_bits() >> 23) + 1;
        if f64::from(f32::from_bits((exponent - 1) << 23)) * STEPS >= size { exponent - 1 } else { exponent }
    });
    node.p = low;
    node.e = step.map(|exponent| exponent as u8);
    let size = DVec3::from_array(step.map(|exponent| f64::from(f32::from_bits(exponent << 23))));
    let CwBvhNode { child_min_x, child_max_x, child_min_y, child_max_y, child_min_z, child_max_z, .. } = node;
    let lowest = [child_min_x, child_min_y, child_min_z];
    let highest = [child_max_x, child_max_y, child_max_z];
    for (axis, (lowest, highest)) in lowest.into_iter().zip(highest).enumerate() {
        for (child, (from, to)) in children.iter().enumerate().filter(|(_, child)| child.0.x <= child.1.x) {
            let steps = |bound: Vec3| (f64::from(bound[axis]) - origin[axis]) / size[axis];
            lowest[child] = steps(*from).floor() as u8;
            highest[child] = steps(*to).ceil() as u8;
        }
    }
}

/// Returns the number of levels of a BVH.
fn depth(hierarchy: &CwBvh) -> usize {
    let mut deepest = 0;
    let mut open = Vec::new();
    if !hierarchy.nodes.is_empty() {
        open.push((0u32, 1usize));
    }
    while let Some((index, level)) = open.pop() {
        deepest = deepest.max(level);
        let node = &hierarchy.nodes[index as usize];
        let nodes = (0..8).filter(|&child| !node.is_child_empty(child) && !node.is_leaf(child));
        open.extend(nodes.map(|child| (node.child_node_index(child), level + 1)));
    }
    deepest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles of all sizes at random places.
    fn soup(seed: u32, scale: f32) -> Mesh {
        let mut state = seed;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32 - 0.5
        };
        let mut mesh = Mesh::default();
        for number in 0..500u32 {
            let corner = Vec3::new(random(), random(), random()) * scale;
            let size = 0.001 * 1.01f32.powi(number as i32) * scale;
            mesh.positions.push(corner);
            mesh.positions.extend([0, 1].map(|_| corner + Vec3::new(random(), random(), 0.0) * size));
            mesh.triangles.push([3 * number, 3 * number + 1, 3 * number + 2]);
        }
        mesh
    }

    /// Returns whether each triangle lies in its leaf's box, and each box in its parent's.
    fn holds(hierarchy: &Hierarchy, mesh: &Mesh) -> bool {
        let slack = f64::from(padding(mesh)) * 0.5;
        let inside = |(low, high): (DVec3, DVec3), p: Vec3| {
            let p = p.as_dvec3();
            p.cmpge(low - slack).all() && p.cmple(high + slack).all()
        };
        let mut found = 0;
        for node in hierarchy.nodes() {
            for child in (0..8).filter(|&child| !node.is_child_empty(child) && node.is_leaf(child)) {
                let step = DVec3::from_array(node.e.map(|e| f64::from(f32::from_bits(u32::from(e) << 23))));
                let at =
                    |x: u8, y: u8, z: u8| node.p.as_dvec3() + DVec3::new(x.into(), y.into(), z.into()) * step;
                let bounds = (
                    at(node.child_min_x[child], node.child_min_y[child], node.child_min_z[child]),
                    at(node.child_max_x[child], node.child_max_y[child], node.child_max_z[child]),
                );
                let (first, count) = node.child_primitives(child);
                for &triangle in &hierarchy.order()[first as usize..(first + count) as usize] {
                    found += usize::from(mesh.corners(triangle as usize).iter().all(|&p| inside(bounds, p)));
                }
            }
        }
        found == mesh.triangle_count()
    }

    #[test]
    fn refitted_boxes_hold_their_triangles() {
        let mesh = soup(1, 1.0);
        let all: Vec<u32> = (0..mesh.triangle_count() as u32).collect();
        let mut hierarchy = Hierarchy::build(&mesh, &all).unwrap();
        assert!(holds(&hierarchy, &mesh));
        for (seed, scale) in [(1, 1.0), (2, 1.0), (3, 1e-3), (4, 1e6)] {
            let moved = soup(seed, scale);
            assert!(seed == 1 || !holds(&hierarchy, &moved), "{seed}");
            hierarchy.refit(&moved);
            assert!(holds(&hierarchy, &moved), "{seed}");
        }
        let mut flat = mesh.clone();
        flat.positions.iter_mut().for_each(|p| p.y = 0.25);
        hierarchy.refit(&flat);
        assert!(holds(&hierarchy, &flat));
    }
}
