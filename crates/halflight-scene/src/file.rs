//! Parser and validation of scene files.

use std::path::PathBuf;

use glam::Vec3;
use halflight_core::light::AreaLight;
use halflight_core::scene::Camera;
use toml::de::DeTable;

use crate::alpha::AlphaChoice;
use crate::animation::AnimationEntry;
use crate::camera::read_view;
use crate::error::SceneError;
use crate::light_shape::LightShape;
use crate::light_texture::TextureEntry;
use crate::section::{Found, Section, Source, tables};
use crate::specular::{self, SpecularEntry};
use crate::transform::Transform;

/// Content of a scene file, validated, before any mesh is loaded.
pub(crate) struct SceneFile {
    pub(crate) camera: Camera,
    pub(crate) lights: Vec<AreaLight>,
    /// Texture of every light that has one.
    pub(crate) textures: Vec<Option<TextureEntry>>,
    pub(crate) meshes: Vec<MeshEntry>,
    pub(crate) animation: Option<AnimationEntry>,
}

/// Entry of a `[[mesh]]`.
pub(crate) struct MeshEntry {
    pub(crate) origin: Origin,
    pub(crate) transform: Transform,
    /// Replaces the mesh's own colours and textures.
    pub(crate) albedo: Option<Vec3>,
    pub(crate) smooth: Smooth,
    pub(crate) specular: SpecularEntry,
    pub(crate) emissive: Emissive,
    pub(crate) alpha: AlphaChoice,
    /// Line of the table's header.
    pub(crate) line: usize,
}

/// Surfaces of a mesh that are shaded as smooth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Smooth {
    /// The ones whose file gives normals.
    Auto,
    /// All: normals that the file does not give are computed, without the faces beyond this angle in degrees.
    On(f32),
    /// None.
    Off,
}

/// Default crease angle, degrees: keeps a six-sided column round (60° between its faces) and the edges of a box sharp.
pub(crate) const CREASE_DEG: f32 = 65.0;

impl Smooth {
    /// Angle in degrees between faces from which an edge is sharp where normals are computed.
    pub(crate) fn crease_deg(self) -> f32 {
        match self {
            Self::On(degrees) => degrees,
            Self::Auto | Self::Off => CREASE_DEG,
        }
    }
}

/// Use of the emission of a mesh's materials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Emissive {
    /// None, with a warning where a material emits.
    Unsaid,
    /// None.
    Ignore,
    /// Flat faces become lights; the line of the key.
    Lights(usize),
}

/// Source of a mesh.
pub(crate) enum Origin {
    /// Path as written in the scene file, and the line of the key.
    File(PathBuf, usize),
    /// Name of a generator, its parameters and the lines of their keys.
    Generator { name: String, line: usize, parameters: toml::Table, lines: Vec<(String, usize)> },
}

impl SceneFile {
    /// Reads the text of a scene file.
    pub(crate) fn parse(source: Source<'_>) -> Result<Self, SceneError> {
        let table = DeTable::parse(source.text).map_err(|fault| {
            let line = source.line(fault.span().map_or(0, |span| span.start));
            let message = fault.message().lines().collect::<Vec<_>>().join(", ");
            source.fault(line, format!("not valid TOML: {message}"))
        })?;
        let mut root = Section::of_table(source, "the scene file", 1, table.into_inner());
        root.allow(&["description", "camera", "light", "mesh", "animation"])?;
        root.text("description")?;
        let Some(camera) = root.take("camera") else {
            return Err(root.fault(1, "has no [camera]; add one with eye, target, up and fov_y_deg"));
        };
        let camera = read_camera(Section::new(source, "[camera]", camera)?)?;
        let lights = tables(&mut root, "light", "light")?.into_iter().enumerate();
        let lights = lights.map(|(index, light)| read_light(index, light)).collect::<Result<Vec<_>, _>>()?;
        let (lights, textures): (Vec<_>, Vec<_>) = lights.into_iter().unzip();
        let meshes =
            tables(&mut root, "mesh", "mesh")?.into_iter().map(read_mesh).collect::<Result<Vec<_>, _>>()?;
        let emissive = meshes.iter().any(|mesh| matches!(mesh.emissive, Emissive::Lights(_)));
        if lights.is_empty() && !emissive {
            let hint = "has no [[light]]; without one every picture is black. Add one with corner, edge_u, edge_v and radiance";
            return Err(root.fault(1, hint));
        }
        if meshes.is_empty() {
            return Err(root.fault(1, "has no [[mesh]]; add one with a file or a generator"));
        }
        let animation = match root.take("animation") {
            Some(animation) => {
                let section = Section::new(source, "[animation]", animation)?;
                Some(AnimationEntry::read(section, &camera, lights.len(), meshes.len())?)
            }
            None => None,
        };
        Ok(Self { camera, lights, textures, meshes, animation })
    }
}

fn read_camera(mut section: Section<'_>) -> Result<Camera, SceneError> {
    section.allow(&["eye", "target", "up", "fov_y_deg"])?;
    read_view(&mut section, None)
}

fn read_light(
    index: usize,
    mut section: Section<'_>,
) -> Result<(AreaLight, Option<TextureEntry>), SceneError> {
    let shape = LightShape::read(&mut section)?;
    let radiance = section.vector("radiance")?;
    let radiance = section.require("radiance", "[10, 10, 10]", radiance)?;
    let two_sided = section.flag("two_sided")?.is_some_and(|flag| flag.value);
    let visible = section.flag("visible")?.is_some_and(|flag| flag.value);
    if radiance.value.min_element() < 0.0 {
        let message = format!("radiance is {}, expected no negative numbers", radiance.value);
        return Err(section.fault(radiance.line, message));
    }
    let light = AreaLight { two_sided, visible, ..shape.light(&section, radiance.value)? };
    light.validate(index).map_err(|source| SceneError::Light {
        file: section.source.name.to_string(),
        line: section.line,
        source,
    })?;
    let texture = TextureEntry::read(&mut section)?;
    Ok((light, texture))
}

fn read_mesh(mut section: Section<'_>) -> Result<MeshEntry, SceneError> {
    // Generators validate their own parameters.
    if !section.has("generator") {
        let known = ["file", "generator", "transform", "albedo", "smooth", "crease_deg", "emissive"];
        section.allow(&[&known[..], &specular::KEYS, &AlphaChoice::KEYS].concat())?;
    }
    let line = section.line;
    let file = section.text("file")?;
    let generator = section.text("generator")?;
    let transform = match section.take("transform") {
        Some(value) => read_transform(Section::new(section.source, "transform", value)?)?,
        None => Transform::default(),
    };
    let albedo = section.vector("albedo")?;
    if let Some(albedo) = &albedo
        && (albedo.value.min_element() < 0.0 || albedo.value.max_element() > 1.0)
    {
        let message = format!("albedo is {}, expected numbers from 0 to 1", albedo.value);
        return Err(section.fault(albedo.line, message));
    }
    let albedo = albedo.map(|albedo| albedo.value);
    let smooth = read_smooth(&mut section)?;
    let specular = SpecularEntry::read(&mut section)?;
    let emissive = read_emissive(&mut section, generator.is_some())?;
    let alpha = AlphaChoice::read(&mut section, albedo.is_none() && generator.is_none())?;
    let origin = match (file, generator) {
        (Some(file), None) => Origin::File(file.value.into(), file.line),
        (None, Some(generator)) => {
            let (parameters, lines) = section.rest()?;
            Origin::Generator { name: generator.value, line: generator.line, parameters, lines }
        }
        (Some(_), Some(generator)) => {
            return Err(section.fault(generator.line, "has both a file and a generator; keep one of them"));
        }
        (None, None) => {
            let message = "has no source; write file = \"mesh.obj\" (or .ply), or generator = \"name\"";
            return Err(section.fault(line, message));
        }
    };
    Ok(MeshEntry { origin, transform, albedo, smooth, specular, emissive, alpha, line })
}

fn read_smooth(section: &mut Section<'_>) -> Result<Smooth, SceneError> {
    let crease = section.number("crease_deg")?;
    if let Some(crease) = &crease
        && !(0.0..=180.0).contains(&crease.value)
    {
        let message = format!("crease_deg is {}, expected an angle from 0 to 180 degrees", crease.value);
        return Err(section.fault(crease.line, message));
    }
    let smooth = match section.text("smooth")? {
        None => Smooth::Auto,
        Some(word) => match word.value.as_str() {
            "auto" => Smooth::Auto,
            "on" => Smooth::On(crease.as_ref().map_or(CREASE_DEG, |crease| crease.value)),
            "off" => Smooth::Off,
            other => {
                let message = format!("smooth is \"{other}\", expected \"auto\", \"on\" or \"off\"");
                return Err(section.fault(word.line, message));
            }
        },
    };
    match (smooth, crease) {
        (Smooth::Auto | Smooth::Off, Some(crease)) => {
            Err(section.fault(crease.line, "crease_deg is for computed normals; add smooth = \"on\""))
        }
        _ => Ok(smooth),
    }
}

fn read_emissive(section: &mut Section<'_>, generated: bool) -> Result<Emissive, SceneError> {
    let Some(Found { value, line }) = section.text("emissive")? else { return Ok(Emissive::Unsaid) };
    match value.as_str() {
        "lights" if generated => {
            Err(section.fault(line, "emissive is for the materials of a file; generators have [[light]]"))
        }
        "lights" => Ok(Emissive::Lights(line)),
        "ignore" => Ok(Emissive::Ignore),
        other => {
            let message = format!("emissive is \"{other}\", expected \"lights\" or \"ignore\"");
            Err(section.fault(line, message))
        }
    }
}

fn read_transform(mut section: Section<'_>) -> Result<Transform, SceneError> {
    section.allow(&["translate", "rotate_deg", "scale"])?;
    let mut transform = Transform::default();
    if let Some(translate) = section.double_vector("translate")? {
        transform.translate = translate.value;
    }
    if let Some(rotate) = section.double_vector("rotate_deg")? {
        transform.rotate_deg = rotate.value;
    }
    if let Some(scale) = section.number_or_vector("scale")? {
        if scale.value.abs().min_element() == 0.0 {
            let message = format!("scale is {}, expected no zero: it would flatten the mesh", scale.value);
            return Err(section.fault(scale.line, message));
        }
        transform.scale = scale.value;
    }
    Ok(transform)
}
