//! Shapes of lights in scene files.

use glam::Vec3;
use halflight_core::light::AreaLight;

use crate::error::SceneError;
use crate::light_texture::TextureEntry;
use crate::section::{Found, Section};

/// Keys of every light.
const COMMON: [&str; 4] = ["shape", "radiance", "two_sided", "visible"];

/// Shape of a `[[light]]`, as its keys give it.
pub(crate) enum LightShape {
    Parallelogram { corner: Vec3, edge_u: Vec3, edge_v: Vec3 },
    Disk { centre: Vec3, normal: Vec3, radius: f32 },
    Ellipse { centre: Vec3, axis_u: Vec3, axis_v: Vec3 },
    Polygon { points: Vec<Vec3>, line: usize },
    Sphere { centre: Vec3, radius: f32 },
}

impl LightShape {
    /// Reads the keys of a light's shape.
    pub(crate) fn read(section: &mut Section<'_>) -> Result<Self, SceneError> {
        let shape = section.text("shape")?;
        let (name, line) = match shape {
            None => ("parallelogram".to_string(), section.line),
            Some(Found { value, line }) => (value, line),
        };
        let allow = |keys: &[&str]| {
            let textures: &[&str] = if name == "parallelogram" { &TextureEntry::KEYS } else { &[] };
            section.allow(&[keys, &COMMON, textures].concat())
        };
        match name.as_str() {
            "parallelogram" => {
                allow(&["corner", "edge_u", "edge_v"])?;
                Ok(Self::Parallelogram {
                    corner: vector(section, "corner", "[-0.5, 3, -0.5]")?,
                    edge_u: vector(section, "edge_u", "[1, 0, 0]")?,
                    edge_v: vector(section, "edge_v", "[0, 0, 1]")?,
                })
            }
            "disk" => {
                allow(&["centre", "normal", "radius"])?;
                let centre = vector(section, "centre", "[0, 3, 0]")?;
                let normal = section.vector("normal")?;
                let normal = section.require("normal", "[0, -1, 0]", normal)?;
                if normal.value.as_dvec3().try_normalize().is_none() {
                    return Err(
                        section.fault(normal.line, "normal is zero, expected a direction such as [0, -1, 0]")
                    );
                }
                Ok(Self::Disk { centre, normal: normal.value, radius: radius(section)? })
            }
            "ellipse" => {
                allow(&["centre", "axis_u", "axis_v"])?;
                Ok(Self::Ellipse {
                    centre: vector(section, "centre", "[0, 3, 0]")?,
                    axis_u: vector(section, "axis_u", "[0.5, 0, 0]")?,
                    axis_v: vector(section, "axis_v", "[0, 0, 0.3]")?,
                })
            }
            "polygon" => {
                allow(&["points"])?;
                let points = section.vectors("points")?;
                let example = "[[0, 3, 0], [1, 3, 0], [0.5, 3, 1]]";
                let points = section.require("points", example, points)?;
                Ok(Self::Polygon { points: points.value, line: points.line })
            }
            "sphere" => {
                allow(&["centre", "radius"])?;
                if let Some(flag) = section.flag("two_sided")? {
                    let message =
                        "two_sided has no meaning for a sphere, which emits to all sides; remove it";
                    return Err(section.fault(flag.line, message));
                }
                Ok(Self::Sphere { centre: vector(section, "centre", "[0, 3, 0]")?, radius: radius(section)? })
            }
            other => {
                let message =
                    format!("shape is `{other}`, expected parallelogram, disk, ellipse, polygon or sphere");
                Err(section.fault(line, message))
            }
        }
    }

    /// Light of this shape.
    pub(crate) fn light(self, section: &Section<'_>, radiance: Vec3) -> Result<AreaLight, SceneError> {
        match self {
            Self::Parallelogram { corner, edge_u, edge_v } => {
                Ok(AreaLight::parallelogram(corner, edge_u, edge_v, radiance))
            }
            Self::Disk { centre, normal, radius } => Ok(AreaLight::disk(centre, normal, radius, radiance)),
            Self::Ellipse { centre, axis_u, axis_v } => {
                Ok(AreaLight::ellipse(centre, axis_u, axis_v, radiance))
            }
            Self::Sphere { centre, radius } => Ok(AreaLight::sphere(centre, radius, radiance)),
            Self::Polygon { points, line } => AreaLight::polygon(&points, radiance)
                .map_err(|fault| section.fault(line, format!("points: {fault}"))),
        }
    }
}

fn radius(section: &mut Section<'_>) -> Result<f32, SceneError> {
    let radius = section.number("radius")?;
    let radius = section.require("radius", "0.5", radius)?;
    if radius.value <= 0.0 {
        let message = format!("radius is {}, expected metres above 0", radius.value);
        return Err(section.fault(radius.line, message));
    }
    Ok(radius.value)
}

fn vector(section: &mut Section<'_>, key: &str, example: &str) -> Result<Vec3, SceneError> {
    let found = section.vector(key)?;
    Ok(section.require(key, example, found)?.value)
}
