//! Scenes: triangles with materials, area lights and a camera, all in world space.

use std::sync::{Arc, LazyLock};

use glam::{Vec2, Vec3};

use crate::alpha::AlphaMask;
pub use crate::camera::Camera;
use crate::light::{AreaLight, LightError};
use crate::light_texture::{LightTexture, PlacedTexture};
pub use crate::limits::{MAX_COORDINATE, MIN_DIAGONAL};
pub use crate::specular::Specular;

/// A scene: one triangle mesh, its lights and the camera that looks at it.
///
/// World space, metres, right-handed, y up. Several lights are summed.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// All geometry, already transformed to world space, shared between scenes that differ in lights and camera only.
    pub mesh: Arc<Mesh>,
    /// The area lights. They are not geometry: they cast no shadow, and the camera sees those alone that are [visible](AreaLight::visible).
    pub lights: Vec<AreaLight>,
    /// Textures that lights refer to.
    pub light_textures: Vec<Arc<LightTexture>>,
    /// The camera.
    pub camera: Camera,
}

impl Scene {
    /// Texture of a light; none for a uniform one.
    #[inline]
    pub fn light_texture(&self, light: &AreaLight) -> Option<PlacedTexture<'_>> {
        let place = light.texture?;
        let texture = self.light_textures.get(place.index as usize)?;
        Some(PlacedTexture { texture, transposed: place.transposed })
    }

    /// Checks that the lights can be used and that their textures exist.
    ///
    /// # Errors
    /// The first fault found.
    pub fn validate_lights(&self) -> Result<(), LightError> {
        let count = self.light_textures.len();
        self.lights.iter().enumerate().try_for_each(|(index, light)| {
            light.validate(index)?;
            match light.texture {
                Some(place) if place.index as usize >= count => {
                    Err(LightError::Texture { index, texture: place.index, count })
                }
                _ => Ok(()),
            }
        })
    }
}

/// Indexed triangles with per-vertex attributes and per-triangle materials.
///
/// `normals`, where there are any, and `uvs` have one entry a vertex; `material_ids` has one a triangle and indexes `materials`.
/// Triangles are not degenerate and coordinates are finite: the loaders see to it, and
/// [`Mesh::validate`] tells for meshes built by hand.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Vertex positions, world space, metres.
    pub positions: Vec<Vec3>,
    /// Shading normals, world space, of any length above 0, on either side: see [`SmoothTriangle`](crate::smooth::SmoothTriangle). The triangles
    /// at a vertex without one (zero) are flat. Empty where all are.
    pub normals: Vec<Vec3>,
    /// Texture coordinates; (0, 0) is the lower left of the image.
    pub uvs: Vec<Vec2>,
    /// Vertex indices of every triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Index into `materials` for every triangle.
    pub material_ids: Vec<u32>,
    /// Materials.
    pub materials: Vec<Material>,
    /// Albedo textures that materials refer to.
    pub textures: Vec<Texture>,
    /// Alpha masks that materials refer to.
    pub alpha_masks: Vec<AlphaMask>,
}

/// A material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Linear RGB base colour in 0 … 1, multiplied with the texture where there is one: the albedo of what is not metal.
    pub albedo: Vec3,
    /// Index into [`Mesh::textures`].
    pub texture: Option<u32>,
    /// Specular reflection; matte without.
    pub specular: Option<Specular>,
    /// Index into [`Mesh::alpha_masks`]: only solid texels hide light and are seen.
    pub alpha_mask: Option<u32>,
}

impl Default for Material {
    fn default() -> Self {
        Self { albedo: Vec3::splat(0.8), texture: None, alpha_mask: None, specular: None }
    }
}

/// A texture of 8-bit sRGB texels, row by row from the top. They are decoded where they are looked up, so that a texture
/// takes four bytes a texel.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// `width * height` texels: red, green and blue in sRGB, and alpha, which [`Mesh::alpha_masks`] are made of where asked.
    pub texels: Vec<[u8; 4]>,
}

/// Linear values of the 256 values of an sRGB channel (IEC 61966-2-1).
pub static SRGB_TO_LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|encoded| {
        let value = encoded as f64 / 255.0;
        let linear = if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) };
        linear as f32
    })
});

impl Texture {
    /// Linear RGB of the texel at `index`, row by row from the top; white where there is none.
    #[inline]
    pub fn linear(&self, index: usize) -> Vec3 {
        let decode = |channel: u8| SRGB_TO_LINEAR[usize::from(channel)];
        self.texels.get(index).map_or(Vec3::ONE, |&[r, g, b, _]| Vec3::new(decode(r), decode(g), decode(b)))
    }
}

/// Why a mesh cannot be rendered.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// An attribute array has the wrong length.
    #[error("mesh has {found} {attribute}, expected {expected}")]
    Length {
        /// Which array.
        attribute: &'static str,
        /// Its length.
        found: usize,
        /// The length it must have.
        expected: usize,
    },
    /// A triangle refers to a vertex, material, texture or alpha mask that does not exist.
    #[error("triangle {triangle} refers to {what} {index}, but there are only {count}")]
    Index {
        /// The triangle.
        triangle: usize,
        /// Kind of thing that it refers to.
        what: &'static str,
        /// The index it holds.
        index: u32,
        /// How many there are.
        count: usize,
    },
    /// A value of a material's specular reflection is out of range.
    #[error("material {material} has a {value} outside 0 to 1")]
    Specular {
        /// Index of the material.
        material: usize,
        /// Name of the value.
        value: &'static str,
    },
    /// A coordinate is NaN or infinite.
    #[error("vertex {vertex} has a position that is not finite")]
    NotFinite {
        /// The vertex.
        vertex: usize,
    },
    /// Single precision cannot work with distances so large.
    #[error(
        "vertex {vertex} lies {MAX_COORDINATE:e} m or more from the origin along an axis; scenes may range from {MIN_DIAGONAL:e} \
         to {MAX_COORDINATE:e} m: scale the scene down"
    )]
    TooFar {
        /// The vertex.
        vertex: usize,
    },
    /// Single precision cannot work with distances so small.
    #[error(
        "the mesh measures less than {MIN_DIAGONAL:e} m across; scenes may range from {MIN_DIAGONAL:e} to {MAX_COORDINATE:e} m: \
         scale the scene up"
    )]
    TooSmall,
    /// More vertices or triangles than 32-bit indices can name.
    #[error("mesh has more than {} triangles or vertices", u32::MAX / 4)]
    TooLarge,
}

impl Mesh {
    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// The three corners of triangle `index`, world space.
    #[inline]
    pub fn corners(&self, index: usize) -> [Vec3; 3] {
        self.triangles[index].map(|vertex| self.positions[vertex as usize])
    }

    /// Alpha mask of triangle `index`; none where all of it is solid.
    #[inline]
    pub fn alpha_mask(&self, index: usize) -> Option<&AlphaMask> {
        if self.alpha_masks.is_empty() {
            return None;
        }
        let mask = self.materials[self.material_ids[index] as usize].alpha_mask?;
        self.alpha_masks.get(mask as usize)
    }

    /// Smallest box around all vertices as (minimum, maximum); `None` for a mesh without vertices.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let first = *self.positions.first()?;
        Some(self.positions.iter().fold((first, first), |(low, high), &p| (low.min(p), high.max(p))))
    }

    /// True if a material reflects specularly.
    pub fn is_glossy(&self) -> bool {
        self.materials.iter().any(|material| material.specular.is_some())
    }

    /// Checks array lengths, indices, materials, and that coordinates are finite and in range, so that no later stage has to.
    ///
    /// # Errors
    /// The first fault found, naming the triangle or vertex.
    pub fn validate(&self) -> Result<(), MeshError> {
        let limit = (u32::MAX / 4) as usize;
        if self.positions.len() > limit || self.triangles.len() > limit {
            return Err(MeshError::TooLarge);
        }
        let length = |attribute, found, expected| {
            if found == expected { Ok(()) } else { Err(MeshError::Length { attribute, found, expected }) }
        };
        if !self.normals.is_empty() {
            length("normals", self.normals.len(), self.positions.len())?;
        }
        length("texture coordinates", self.uvs.len(), self.positions.len())?;
        length("material ids", self.material_ids.len(), self.triangles.len())?;
        if let Some(vertex) = self.positions.iter().position(|p| !p.is_finite()) {
            return Err(MeshError::NotFinite { vertex });
        }
        if let Some(vertex) = self.positions.iter().position(|p| p.abs().max_element() >= MAX_COORDINATE) {
            return Err(MeshError::TooFar { vertex });
        }
        // A product of two small differences may be 0.
        let (low, high) = self.bounds().unwrap_or_default();
        if !self.triangles.is_empty() && (high - low).as_dvec3().length() < f64::from(MIN_DIAGONAL) {
            return Err(MeshError::TooSmall);
        }
        for (material, specular) in self.materials.iter().map(|material| material.specular).enumerate() {
            if let Some(value) = specular.and_then(|specular| specular.fault()) {
                return Err(MeshError::Specular { material, value });
            }
        }
        let check = |triangle, what, index: u32, count: usize| {
            if (index as usize) < count {
                Ok(())
            } else {
                Err(MeshError::Index { triangle, what, index, count })
            }
        };
        for (triangle, (vertices, &material)) in self.triangles.iter().zip(&self.material_ids).enumerate() {
            for &vertex in vertices {
                check(triangle, "vertex", vertex, self.positions.len())?;
            }
            check(triangle, "material", material, self.materials.len())?;
            if let Some(texture) = self.materials[material as usize].texture {
                check(triangle, "texture", texture, self.textures.len())?;
            }
            if let Some(mask) = self.materials[material as usize].alpha_mask {
                check(triangle, "alpha mask", mask, self.alpha_masks.len())?;
            }
        }
        Ok(())
    }
}
