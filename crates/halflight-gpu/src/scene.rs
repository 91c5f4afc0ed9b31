//! A scene on the device: its BVHs, triangles and materials.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use halflight_core::scene::{Mesh, SRGB_TO_LINEAR};
use halflight_core::smooth::{SmoothTriangle, is_smooth};

use crate::bindings::Slot;
use crate::error::{GpuError, caught};
use crate::masked::{Hierarchies, Parted};
use crate::memory::Memory;
use crate::specular::glosses;

/// Marks a material without a texture.
const NONE: u32 = u32::MAX;

/// Twin of `Material` in `shaders/resolve.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuMaterial {
    albedo: [f32; 3],
    pub(crate) texels: u32,
    pub(crate) size: [u32; 2],
    padding: [u32; 2],
}

/// Buffers that last as long as the scene, and the BVHs that two of them hold.
#[derive(Debug)]
pub(crate) struct SceneBuffers {
    /// Buffers by slot.
    pub(crate) slots: Vec<(Slot, wgpu::Buffer)>,
    hierarchies: Hierarchies,
    /// Corners to rasterize.
    pub(crate) corners: Corners,
    /// True if any surface was smooth at first: those that become so later stay flat.
    smooth: bool,
    pub(crate) extent: Extent,
}

/// Numbers of corners in [`Slot::Triangles`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corners {
    /// Number of those of triangles without alpha masks, which come first.
    pub(crate) opaque: u32,
    /// Number of all.
    pub(crate) all: u32,
}

/// Extent of a mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    /// Diagonal, metres.
    pub(crate) diagonal: f32,
    /// Largest absolute coordinate, metres.
    pub(crate) largest: f32,
}

impl Extent {
    fn of(mesh: &Mesh) -> Self {
        let (low, high) = mesh.bounds().unwrap_or_default();
        Self { diagonal: (high - low).length(), largest: low.abs().max(high.abs()).max_element() }
    }
}

impl SceneBuffers {
    /// Builds the BVHs of a valid mesh and uploads everything.
    ///
    /// # Errors
    /// The mesh is too large for the device, or a BVH too deep; or the device is full or lost.
    pub(crate) fn new(memory: &Memory, mesh: &Mesh, parted: &Parted) -> Result<Self, GpuError> {
        let hierarchies = Hierarchies::build(mesh, parted)?;
        let (nodes, order) = (hierarchies.nodes(), hierarchies.order());
        let order = &*order;
        let triangles = corners(mesh, order);
        let faces: Vec<[u32; 2]> =
            order.iter().map(|&index| [index, mesh.material_ids[index as usize]]).collect();
        let textured = !mesh.textures.is_empty();
        let uv = |vertex: u32| mesh.uvs[vertex as usize].to_array();
        let uvs: Vec<[f32; 2]> =
            order.iter().filter(|_| textured).flat_map(|&t| mesh.triangles[t as usize].map(uv)).collect();
        let (materials, texels) = materials(mesh);
        let smooth = is_smooth(mesh);
        let normals = corner_normals(mesh, order, smooth);
        let (masked, solid) = hierarchies.masks(mesh)?;
        let glosses = glosses(mesh);
        let contents: [(Slot, &[u8]); 10] = [
            (Slot::Glosses, bytemuck::cast_slice(&glosses)),
            (Slot::Nodes, bytemuck::cast_slice(&nodes)),
            (Slot::Triangles, bytemuck::cast_slice(&triangles)),
            (Slot::CornerNormals, bytemuck::cast_slice(&normals)),
            (Slot::Faces, bytemuck::cast_slice(&faces)),
            (Slot::Materials, bytemuck::cast_slice(&materials)),
            (Slot::Uvs, bytemuck::cast_slice(&uvs)),
            (Slot::Textures, bytemuck::cast_slice(&texels)),
            (Slot::Masked, &masked),
            (Slot::Solid, bytemuck::cast_slice(&solid)),
        ];
        let upload = |&(slot, bytes): &(Slot, &[u8])| {
            let label = slot.label();
            memory.check(label, bytes.len() as u64, "scenes with fewer triangles or texels fit")?;
            let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
            Ok((slot, memory.filled(label, bytes, usage)?))
        };
        let slots = caught(&memory.device, GpuError::Memory, || contents.iter().map(upload).collect())?;
        let corners = Corners { opaque: 3 * parted.opaque.len() as u32, all: 3 * order.len() as u32 };
        Ok(Self { slots, corners, smooth, extent: Extent::of(mesh), hierarchies })
    }

    /// Records the same triangles in other places: the BVHs are refitted, and written with the triangles to the buffers there are.
    ///
    /// # Errors
    /// The device is full or lost; the buffers are then as they were.
    pub(crate) fn update(
        &mut self,
        memory: &Memory,
        encoder: &mut wgpu::CommandEncoder,
        mesh: &Mesh,
    ) -> Result<(), GpuError> {
        // Boxes belong to no mesh if the rest fails; the next call makes all of them anew.
        self.hierarchies.refit(mesh);
        let (nodes, order) = (self.hierarchies.nodes(), self.hierarchies.order());
        let (triangles, normals) = (corners(mesh, &order), corner_normals(mesh, &order, self.smooth));
        let contents: [(Slot, &[u8]); 3] = [
            (Slot::Nodes, bytemuck::cast_slice(&nodes)),
            (Slot::Triangles, bytemuck::cast_slice(&triangles)),
            (Slot::CornerNormals, bytemuck::cast_slice(&normals)),
        ];
        let contents =
            contents.into_iter().filter(|(_, bytes)| !bytes.is_empty()).flat_map(|(slot, bytes)| {
                let buffer = self.slots.iter().find(|(known, _)| *known == slot);
                buffer.map(|(_, buffer)| (slot.label(), bytes, buffer))
            });
        memory.write(encoder, &contents.collect::<Vec<_>>())?;
        self.extent = Extent::of(mesh);
        Ok(())
    }
}

/// Returns the corners of triangles with the unit normal in the fourth components. The normal is that of the G-buffer on the CPU: edges in single
/// precision, their product in double.
fn corners(mesh: &Mesh, order: &[u32]) -> Vec<[f32; 4]> {
    let corners = |&triangle: &u32| {
        let [a, b, c] = mesh.corners(triangle as usize);
        let normal = facet_normal(mesh, triangle);
        [a.extend(normal.x), b.extend(normal.y), c.extend(normal.z)].map(|corner| corner.to_array())
    };
    order.iter().flat_map(corners).collect()
}

/// Returns the shading normals of the corners of triangles, on the side of their unit normals; zero for flat triangles. Empty for a scene
/// without smooth surfaces.
fn corner_normals(mesh: &Mesh, order: &[u32], smooth: bool) -> Vec<[f32; 4]> {
    let normals = |&triangle: &u32| {
        let smooth = SmoothTriangle::new(mesh, triangle as usize, facet_normal(mesh, triangle));
        let normals = smooth.map_or([Vec3::ZERO; 3], |smooth| smooth.normals);
        normals.map(|normal| normal.extend(0.0).to_array())
    };
    order.iter().filter(|_| smooth).flat_map(normals).collect()
}

fn facet_normal(mesh: &Mesh, triangle: u32) -> Vec3 {
    let [a, b, c] = mesh.corners(triangle as usize);
    (b - a).as_dvec3().cross((c - a).as_dvec3()).normalize_or_zero().as_vec3()
}

/// Returns materials, and texels behind the table that decodes their channels: the bits of 256 linear values, those of the CPU.
fn materials(mesh: &Mesh) -> (Vec<GpuMaterial>, Vec<u32>) {
    let mut places = Vec::with_capacity(mesh.textures.len());
    let mut texels = Vec::new();
    if !mesh.textures.is_empty() {
        texels.extend(SRGB_TO_LINEAR.iter().map(|value| value.to_bits()));
    }
    for texture in &mesh.textures {
        let whole = (texture.width as usize * texture.height as usize).min(texture.texels.len());
        let usable = whole > 0 && whole == texture.width as usize * texture.height as usize;
        places.push(if usable { texels.len() as u32 } else { NONE });
        texels.extend(texture.texels.iter().take(whole).map(|&texel| u32::from_le_bytes(texel)));
    }
    let materials = mesh.materials.iter().map(|material| {
        let texture = material.texture.map(|index| index as usize);
        let size = texture.map_or([0; 2], |index| [mesh.textures[index].width, mesh.textures[index].height]);
        GpuMaterial {
            albedo: material.albedo.to_array(),
            texels: texture.map_or(NONE, |index| places[index]),
            size,
            padding: [0; 2],
        }
    });
    (materials.collect(), texels)
}
