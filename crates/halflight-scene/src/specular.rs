//! Specular reflection of the meshes of a scene file.

use glam::Vec3;
use halflight_core::scene::{Material, Specular};

use crate::error::SceneError;
use crate::section::Section;

/// Keys of a mesh's table.
pub(crate) const KEYS: [&str; 4] = ["specular", "roughness", "metallic", "reflectance"];

/// Specular reflection of a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SpecularEntry {
    from: From,
    roughness: Option<f32>,
    metallic: Option<f32>,
    reflectance: Option<Vec3>,
}

/// Materials of a file that reflect specularly.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum From {
    /// The ones with roughness or metallicity.
    #[default]
    Auto,
    /// Also those with a specular colour and an exponent, which many programs write for matte surfaces as well.
    Phong,
    /// None.
    Off,
}

impl SpecularEntry {
    /// Takes the keys of a mesh's table.
    pub(crate) fn read(section: &mut Section<'_>) -> Result<Self, SceneError> {
        let from = match section.text("specular")? {
            None => From::Auto,
            Some(word) => match word.value.as_str() {
                "auto" => From::Auto,
                "phong" => From::Phong,
                "off" => From::Off,
                other => {
                    let message = format!("specular is \"{other}\", expected \"auto\", \"phong\" or \"off\"");
                    return Err(section.fault(word.line, message));
                }
            },
        };
        let mut unit = |key: &str| match section.number(key)? {
            Some(found) if !(0.0..=1.0).contains(&found.value) => {
                let message = format!("{key} is {}, expected a number from 0 to 1", found.value);
                Err(section.fault(found.line, message))
            }
            found => Ok(found.map(|found| found.value)),
        };
        let (roughness, metallic) = (unit("roughness")?, unit("metallic")?);
        let reflectance = section.vector("reflectance")?;
        if let Some(found) = &reflectance
            && (found.value.min_element() < 0.0 || found.value.max_element() > 1.0)
        {
            let message = format!("reflectance is {}, expected numbers from 0 to 1", found.value);
            return Err(section.fault(found.line, message));
        }
        let reflectance = reflectance.map(|found| found.value);
        let entry = Self { from, roughness, metallic, reflectance };
        if from == From::Off && entry != (Self { from, ..Self::default() }) {
            let message =
                "has specular = \"off\" beside roughness, metallic or reflectance; keep one of them";
            return Err(section.fault(section.line, message));
        }
        Ok(entry)
    }

    /// True if `Ks` and `Ns` of material libraries are wanted.
    pub(crate) fn phong(&self) -> bool {
        self.from == From::Phong
    }

    /// Applies the keys to a material of the mesh.
    pub(crate) fn apply(&self, material: &mut Material) {
        let Self { from, roughness, metallic, reflectance } = *self;
        if from == From::Off {
            material.specular = None;
        }
        if (roughness, metallic, reflectance) == (None, None, None) {
            return;
        }
        let given = material.specular.unwrap_or_default();
        material.specular = Some(Specular {
            roughness: roughness.unwrap_or(given.roughness),
            metallic: metallic.unwrap_or(given.metallic),
            reflectance: reflectance.unwrap_or(given.reflectance),
        });
    }
}
