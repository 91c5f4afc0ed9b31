//! Specular reflection of surfaces: GGX microfacets, described by metallicity and roughness as in glTF 2.0 (Appendix B).

use glam::Vec3;

/// Specular part of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Specular {
    /// Perceptual roughness in 0 … 1; its square is the α of GGX.
    pub roughness: f32,
    /// Metallicity in 0 … 1: how much the base colour is reflectance at normal incidence instead of diffuse albedo.
    pub metallic: f32,
    /// Linear RGB reflectance at normal incidence of what is not metal, in 0 … 1.
    pub reflectance: Vec3,
}

impl Default for Specular {
    /// Returns glTF's dielectric, of index of refraction 1.5, with half roughness.
    fn default() -> Self {
        Self { roughness: 0.5, metallic: 0.0, reflectance: Vec3::splat(0.04) }
    }
}

impl Specular {
    /// Specular reflection of a surface point of base colour `base`.
    #[inline]
    pub fn surface(&self, base: Vec3) -> SurfaceSpecular {
        SurfaceSpecular { f0: self.reflectance.lerp(base, self.metallic), roughness: self.roughness }
    }

    /// Diffuse albedo of a surface point of base colour `base`: metals have none.
    #[inline]
    pub fn diffuse(&self, base: Vec3) -> Vec3 {
        base * (1.0 - self.metallic)
    }

    /// Name of the first value that lies outside 0 … 1, if any.
    pub fn fault(&self) -> Option<&'static str> {
        let unit = |value: f32| (0.0..=1.0).contains(&value);
        let values = [
            ("roughness", unit(self.roughness)),
            ("metallic", unit(self.metallic)),
            ("reflectance", self.reflectance.to_array().into_iter().all(unit)),
        ];
        values.into_iter().find(|(_, fits)| !fits).map(|(name, _)| name)
    }
}

/// Specular reflection at a surface point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceSpecular {
    /// Linear RGB reflectance at normal incidence, 0 … 1. Black is a matte surface, which reflects at no angle.
    pub f0: Vec3,
    /// Perceptual roughness in 0 … 1.
    pub roughness: f32,
}

impl SurfaceSpecular {
    /// A surface that is only diffuse.
    pub const MATTE: Self = Self { f0: Vec3::ZERO, roughness: 1.0 };

    /// True if the surface reflects nothing specularly.
    #[inline]
    pub fn is_matte(&self) -> bool {
        self.f0 == Vec3::ZERO
    }
}
