//! A scene on the device: its BVH, triangles and materials.

use std::time::Duration;

use crate::crowds::Crowds;
use bytemuck::{Pod, Zeroable};
use halflight_core::scene::{Mesh, SRGB_TO_LINEAR, Scene};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh;

use crate::GpuError;
use crate::buffers::{check_size, filled};
use crate::error::caught;

/// Levels of a BVH that shaders can traverse: `STACK` in `shaders/visibility/bvh.wgsl`.
pub(crate) const STACK: usize = 32;

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

/// Buffers that last as long as the scene.
#[derive(Clone, Debug)]
pub(crate) struct SceneBuffers {
    pub(crate) nodes: wgpu::Buffer,
    pub(crate) triangles: wgpu::Buffer,
    pub(crate) faces: wgpu::Buffer,
    pub(crate) materials: wgpu::Buffer,
    pub(crate) uvs: wgpu::Buffer,
    pub(crate) textures: wgpu::Buffer,
    /// Corners to rasterize.
    pub(crate) vertices: u32,
    /// Diagonal of the scene, metres.
    pub(crate) size: f32,
}

impl SceneBuffers {
    /// Builds the BVH of a valid scene and uploads everything.
    ///
    /// # Errors
    /// The scene is too large for the device, or its BVH too deep; or the device is full or lost.
    pub(crate) fn new(device: &wgpu::Device, scene: &Scene) -> Result<Self, GpuError> {
        let mesh = &scene.mesh;
        let (low, high) = mesh.bounds().unwrap_or_default();
        let largest = low.abs().max(high.abs()).max_element();
        let size = (high - low).length();
        // As on the CPU: box tests are wrong by a few units in the last place of distances inside the scene, and of the
        // boxes' own coordinates.
        let hierarchy = hierarchy(mesh, (size * 2f32.powi(-17)).max(largest * 2f32.powi(-21)));
        let depth = depth(&hierarchy);
        if depth > STACK {
            return Err(GpuError::TooDeep { depth, limit: STACK });
        }
        let order = &hierarchy.primitive_indices;
        let triangles: Vec<[f32; 4]> = order.iter().flat_map(|&index| corners(mesh, index)).collect();
        let faces: Vec<[u32; 2]> =
            order.iter().map(|&index| [index, mesh.material_ids[index as usize]]).collect();
        let textured = !mesh.textures.is_empty();
        let uv = |vertex: u32| mesh.uvs[vertex as usize].to_array();
        let uvs: Vec<[f32; 2]> =
            order.iter().filter(|_| textured).flat_map(|&t| mesh.triangles[t as usize].map(uv)).collect();
        let (materials, texels) = materials(mesh);
        let upload = |what: &'static str, bytes: &[u8]| -> Result<wgpu::Buffer, GpuError> {
            // Something must be bound where there is nothing.
            let bytes = if bytes.is_empty() { &[0; 32] } else { bytes };
            check_size(
                &device.limits(),
                what,
                bytes.len() as u64,
                "scenes with fewer triangles or texels fit",
            )?;
            filled(device, what, bytes, wgpu::BufferUsages::STORAGE)
        };
        caught(device, GpuError::Memory, || {
            Ok(Self {
                nodes: upload("BVH", bytemuck::cast_slice(&hierarchy.nodes))?,
                triangles: upload("triangles", bytemuck::cast_slice(&triangles))?,
                faces: upload("triangle numbers", bytemuck::cast_slice(&faces))?,
                materials: upload("materials", bytemuck::cast_slice(&materials))?,
                uvs: upload("texture coordinates", bytemuck::cast_slice(&uvs))?,
                textures: upload("textures", bytemuck::cast_slice(&texels))?,
                vertices: 3 * order.len() as u32,
                size,
            })
        })
    }
}

fn hierarchy(mesh: &Mesh, padding: f32) -> CwBvh {
    if mesh.triangles.is_empty() {
        return CwBvh::default();
    }
    let crowds = Crowds::of(mesh);
    let boxes: Vec<Aabb> = (0..mesh.triangle_count())
        .map(|triangle| {
            let (low, high) = crowds.bounds(triangle);
            Aabb::new((low - padding).into(), (high + padding).into())
        })
        .collect();
    build_cwbvh(&boxes, BvhBuildParams::medium_build(), &mut Duration::default())
}

/// Levels of a BVH.
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

/// Corners with the unit normal in the fourth components. The normal is that of the G-buffer on the CPU: edges in single
/// precision, their product in double.
fn corners(mesh: &Mesh, triangle: u32) -> [[f32; 4]; 3] {
    let [a, b, c] = mesh.corners(triangle as usize);
    let normal = (b - a).as_dvec3().cross((c - a).as_dvec3()).normalize_or_zero().as_vec3();
    [a.extend(normal.x), b.extend(normal.y), c.extend(normal.z)].map(|corner| corner.to_array())
}

/// Materials, and texels behind the table that decodes their channels: the bits of 256 linear values, those of the CPU.
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
