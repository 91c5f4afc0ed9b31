//! Triangles with alpha masks: those of a mesh behind the others, in a BVH of their own, with texture coordinates and solid
//! texels.

use std::borrow::Cow;

use bytemuck::{Pod, Zeroable};
use halflight_core::alpha::AlphaMask;
use halflight_core::scene::Mesh;
use obvhs::cwbvh::node::CwBvhNode;

use crate::error::GpuError;
use crate::hierarchy::Hierarchy;

/// Triangles of a mesh by whether they have an alpha mask: places in the mesh, in its order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Parted {
    pub(crate) opaque: Vec<u32>,
    pub(crate) masked: Vec<u32>,
}

impl Parted {
    /// Parts the triangles of a valid mesh.
    pub(crate) fn of(mesh: &Mesh) -> Self {
        let is_masked = |&triangle: &u32| mesh.alpha_mask(triangle as usize).is_some();
        let (masked, opaque) = (0..mesh.triangle_count() as u32).partition(is_masked);
        Self { opaque, masked }
    }

    /// Number of triangles of both kinds.
    pub(crate) fn count(&self) -> usize {
        self.opaque.len() + self.masked.len()
    }
}

/// Both BVHs of a mesh.
#[derive(Debug)]
pub(crate) struct Hierarchies {
    opaque: Hierarchy,
    /// BVH over triangles with an alpha mask, where there are any.
    masked: Option<Hierarchy>,
}

impl Hierarchies {
    /// Builds the BVHs of a valid mesh.
    ///
    /// # Errors
    /// A BVH is deeper than shaders can traverse.
    pub(crate) fn build(mesh: &Mesh, parted: &Parted) -> Result<Self, GpuError> {
        let has_masks = !parted.masked.is_empty();
        Ok(Self {
            opaque: Hierarchy::build(mesh, &parted.opaque)?,
            masked: has_masks.then(|| Hierarchy::build(mesh, &parted.masked)).transpose()?,
        })
    }

    /// Fits the boxes to the same triangles in other places.
    pub(crate) fn refit(&mut self, mesh: &Mesh) {
        self.opaque.refit(mesh);
        if let Some(masked) = &mut self.masked {
            masked.refit(mesh);
        }
    }

    /// Triangles of the mesh by their place in the leaves; those with an alpha mask come last.
    pub(crate) fn order(&self) -> Cow<'_, [u32]> {
        match &self.masked {
            None => self.opaque.order().into(),
            Some(masked) => [self.opaque.order(), masked.order()].concat().into(),
        }
    }

    /// Nodes of both, as shaders read them: node 0 is the root of the opaque triangles, [`Hierarchies::root`] that of the others.
    pub(crate) fn nodes(&self) -> Cow<'_, [CwBvhNode]> {
        let Some(masked) = &self.masked else { return self.opaque.nodes().into() };
        let mut nodes = self.opaque.nodes().to_vec();
        // A root without children, where every triangle has a mask.
        nodes.resize(self.root() as usize, CwBvhNode::default());
        let triangles = self.opaque.order().len() as u32;
        nodes.extend(masked.nodes().iter().map(|node| CwBvhNode {
            child_base_idx: node.child_base_idx.saturating_add(self.root()),
            primitive_base_idx: node.primitive_base_idx.saturating_add(triangles),
            ..*node
        }));
        nodes.into()
    }

    /// Root of the triangles with an alpha mask.
    fn root(&self) -> u32 {
        self.opaque.nodes().len().max(1) as u32
    }

    /// Returns the contents of the buffers of alpha masks: triangles with their masks' places, and texels. Both are empty where there are
    /// none.
    ///
    /// # Errors
    /// A mask has more texels than shaders can count.
    pub(crate) fn masks(&self, mesh: &Mesh) -> Result<(Vec<u8>, Vec<u32>), GpuError> {
        let Some(masked) = &self.masked else { return Ok(Default::default()) };
        let (places, texels) = texels(mesh)?;
        let head = MaskedHead { root: self.root(), first: self.opaque.order().len() as u32 };
        let mut bytes = bytemuck::bytes_of(&head).to_vec();
        for &triangle in masked.order() {
            bytes.extend_from_slice(bytemuck::bytes_of(&MaskedTriangle::new(mesh, triangle, &places)));
        }
        Ok((bytes, texels))
    }
}

/// Twin of the first members of `Masked` in `shaders/shared/masked.wgsl`; the triangles follow.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct MaskedHead {
    pub(crate) root: u32,
    pub(crate) first: u32,
}

/// Twin of `MaskedTriangle` in `shaders/shared/masked.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct MaskedTriangle {
    pub(crate) a: [f32; 2],
    pub(crate) b: [f32; 2],
    pub(crate) c: [f32; 2],
    pub(crate) size: [u32; 2],
    pub(crate) texels: u32,
    padding: u32,
}

impl MaskedTriangle {
    /// Returns a triangle that has a mask; `places` are the first words of all masks.
    fn new(mesh: &Mesh, triangle: u32, places: &[u32]) -> Self {
        let corners = mesh.triangles[triangle as usize].map(|vertex| mesh.uvs[vertex as usize]);
        let [x, y] = [corners.map(|uv| uv.x), corners.map(|uv| uv.y)].map(near_zero);
        let index = mesh.materials[mesh.material_ids[triangle as usize] as usize].alpha_mask;
        let texels = index.and_then(|index| places.get(index as usize)).copied().unwrap_or_default();
        let size = mesh.alpha_mask(triangle as usize).map_or([1; 2], |mask| [mask.width(), mask.height()]);
        Self { a: [x[0], y[0]], b: [x[1], y[1]], c: [x[2], y[2]], size, texels, padding: 0 }
    }
}

/// Returns coordinates of three corners that are as many whole repetitions of the image less as brings them near 0, where single
/// precision is finest; 0 where one is not finite, since the CPU takes the first column or row there.
fn near_zero(corners: [f32; 3]) -> [f32; 3] {
    let whole = f64::from(corners.into_iter().fold(f32::INFINITY, f32::min)).floor();
    match corners.iter().all(|corner| corner.is_finite()) {
        true => corners.map(|corner| (f64::from(corner) - whole) as f32),
        false => [0.0; 3],
    }
}

/// Returns the first word of every mask, and the solid texels of all, 32 a word.
fn texels(mesh: &Mesh) -> Result<(Vec<u32>, Vec<u32>), GpuError> {
    let (mut places, mut words) = (Vec::with_capacity(mesh.alpha_masks.len()), Vec::new());
    for mask in &mesh.alpha_masks {
        check_size(mask)?;
        places.push(words.len() as u32);
        words.extend(mask.words().iter().flat_map(|&word| [word as u32, (word >> 32) as u32]));
    }
    Ok((places, words))
}

/// Checks that places of texels have 32 bits.
fn check_size(mask: &AlphaMask) -> Result<(), GpuError> {
    let needed = u64::from(mask.width()) * u64::from(mask.height());
    let limit = u64::from(u32::MAX);
    match needed <= limit {
        true => Ok(()),
        false => Err(GpuError::TooLarge {
            what: "an alpha mask",
            needed,
            unit: "texels",
            limit,
            advice: "a smaller image fits",
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_moved_by_whole_images() {
        assert_eq!(near_zero([0.25, 1.0, 0.5]), [0.25, 1.0, 0.5]);
        assert_eq!(near_zero([-2.75, 1000.5, -3.0]), [0.25, 1003.5, 0.0]);
        assert_eq!(near_zero([1e6, 1e6 + 0.25, 1e6 + 2.0]), [0.0, 0.25, 2.0]);
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(near_zero([0.5, bad, 0.25]), [0.0; 3]);
        }
    }
}
