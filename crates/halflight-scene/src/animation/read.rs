//! Reader of the `[animation]` of a scene file.

use glam::{DVec3, Vec3};
use halflight_core::light::AreaLight;
use halflight_core::scene::{Camera, Mesh};
use toml::de::DeValue;

use super::place::{Key, LIMIT, Path};
use super::sway::Sway;
use super::track::Track;
use super::{Animation, MeshMotion, Part};
use crate::camera::read_view;
use crate::error::SceneError;
use crate::section::{Found, Section, Source, tables};

/// Animation as written in the file, before meshes are loaded.
pub(crate) struct AnimationEntry {
    camera: Option<Track<Camera>>,
    lights: Vec<Body>,
    meshes: Vec<Body>,
}

/// Content of an `[[animation.light]]` or `[[animation.mesh]]`.
struct Body {
    /// Index of the light or mesh in the file, from 0.
    index: usize,
    track: Option<Track<Key>>,
    axis: DVec3,
    /// Pivot of rotations; the centre of the body if left out.
    pivot: Option<Vec3>,
    sway: Option<SwayEntry>,
    line: usize,
}

struct SwayEntry {
    amplitude: Vec3,
    period: f32,
    /// Height of the foot; the lowest vertex if left out.
    foot: Option<f32>,
    line: usize,
}

impl AnimationEntry {
    /// Reads the section of a file with this camera and these numbers of lights and meshes.
    pub(crate) fn read(
        mut section: Section<'_>,
        camera: &Camera,
        lights: usize,
        meshes: usize,
    ) -> Result<Self, SceneError> {
        section.allow(&["camera", "light", "mesh"])?;
        let path = match section.take("camera") {
            Some(path) => {
                Some(read_camera(Section::new(section.source, "[animation.camera]", path)?, camera)?)
            }
            None => None,
        };
        let entry = Self {
            camera: path,
            lights: read_bodies(&mut section, "light", lights)?,
            meshes: read_bodies(&mut section, "mesh", meshes)?,
        };
        if entry.camera.is_none() && entry.lights.is_empty() && entry.meshes.is_empty() {
            let message = "moves nothing; add [animation.camera], [[animation.light]] or [[animation.mesh]]";
            return Err(section.fault(section.line, message));
        }
        Ok(entry)
    }

    /// Animation of these lights and this mesh, given the parts that the file's meshes make. Lights of emissive faces move with their mesh.
    pub(crate) fn place(
        self,
        source: Source<'_>,
        lights: &[AreaLight],
        mesh: &Mesh,
        parts: &[Part],
    ) -> Result<Animation, SceneError> {
        let mut animation =
            Animation { camera: self.camera, lights: Vec::new(), meshes: Vec::new(), videos: Vec::new() };
        for body in self.lights {
            let (low, high) = lights[body.index].bounds();
            let index = body.index;
            animation.lights.extend(body.path(source, "light", low, high)?.map(|path| (index, path)));
        }
        for mut body in self.meshes {
            let Part { vertices, lights } = parts[body.index].clone();
            let (low, high) = bounds(&mesh.positions[vertices.clone()]);
            if let Some(sway) = body.sway.as_ref().filter(|_| !lights.is_empty()) {
                let message = "sway bends a mesh with emissive = \"lights\", expected keys: lights stay flat";
                return Err(source.fault(sway.line, message));
            }
            let sway = body.sway.take().map(|sway| sway.place(source, low, high)).transpose()?;
            let path = body.path(source, "mesh", low, high)?;
            animation
                .lights
                .extend(lights.zip(path.iter().cycle()).map(|(light, path)| (light, path.clone())));
            animation.meshes.push(MeshMotion { vertices, sway, path });
        }
        Ok(animation)
    }
}

impl Body {
    /// Path of the body, if it has one; `low` and `high` are its bounding box.
    fn path(self, source: Source<'_>, kind: &str, low: Vec3, high: Vec3) -> Result<Option<Path>, SceneError> {
        let pivot = self.pivot.unwrap_or(low + (high - low) * 0.5);
        let path = self.track.map(|track| Path { track, axis: self.axis, pivot });
        if path.as_ref().is_some_and(|path| !path.stays_finite(low, high)) {
            let message = format!(
                "[[animation.{kind}]] moves {kind} {} out of the range of f32; choose a smaller translate or a nearer pivot",
                self.index
            );
            return Err(source.fault(self.line, message));
        }
        Ok(path)
    }
}

impl SwayEntry {
    /// Swaying of a mesh with this bounding box.
    fn place(self, source: Source<'_>, low: Vec3, high: Vec3) -> Result<Sway, SceneError> {
        let foot = self.foot.unwrap_or(low.y);
        let height = high.y - foot;
        let reach = low.abs().max(high.abs()).as_dvec3() + self.amplitude.as_dvec3().abs();
        if !(height > 0.0 && height.is_finite()) {
            let message = format!("sway foot is {foot}, expected a height below the mesh's top, {}", high.y);
            return Err(source.fault(self.line, message));
        }
        if reach.max_element() > LIMIT {
            let message = format!("sway amplitude {} moves the mesh out of the range of f32", self.amplitude);
            return Err(source.fault(self.line, message));
        }
        Ok(Sway { amplitude: self.amplitude, period: self.period, foot, height })
    }
}

fn bounds(points: &[Vec3]) -> (Vec3, Vec3) {
    let first = points.first().copied().unwrap_or_default();
    points.iter().fold((first, first), |(low, high), &point| (low.min(point), high.max(point)))
}

fn read_camera(mut section: Section<'_>, still: &Camera) -> Result<Track<Camera>, SceneError> {
    section.allow(&["keys"])?;
    let example = "[{ time = 4, eye = [0, 1, 3] }]";
    let keys = read_keys(&mut section, "[animation.camera] key", example, still, |key, before| {
        key.allow(&["time", "eye", "target", "up", "fov_y_deg"])?;
        read_view(key, Some(before))
    })?;
    let keys = section.require("keys", example, keys)?;
    Ok(Track::new(*still, keys))
}

/// Reads all bodies of a kind, of which the file has `count`.
fn read_bodies(section: &mut Section<'_>, kind: &'static str, count: usize) -> Result<Vec<Body>, SceneError> {
    let mut bodies: Vec<Body> = Vec::new();
    for body in tables(section, kind, &format!("animation.{kind}"))? {
        let body = read_body(body, kind, count)?;
        if bodies.iter().any(|other| other.index == body.index) {
            let message = format!(
                "[[animation.{kind}]] moves {kind} {} for a second time; put all keys into one",
                body.index
            );
            return Err(section.source.fault(body.line, message));
        }
        bodies.push(body);
    }
    Ok(bodies)
}

fn read_body(mut section: Section<'_>, kind: &'static str, count: usize) -> Result<Body, SceneError> {
    let known: &[&str] = match kind {
        "mesh" => &["mesh", "axis", "pivot", "keys", "sway"],
        _ => &["light", "axis", "pivot", "keys"],
    };
    section.allow(known)?;
    let line = section.line;
    let index = section.index(kind, count)?;
    let index = match index {
        None if count == 1 => 0,
        index => section.require(kind, &format!("0 (of {count}, as they follow in the file)"), index)?,
    };
    let axis = section.vector("axis")?.unwrap_or(Found { value: Vec3::Y, line });
    let Some(unit) = axis.value.as_dvec3().try_normalize() else {
        return Err(section.fault(axis.line, "axis is zero, expected a direction such as [0, 1, 0]"));
    };
    let pivot = section.vector("pivot")?.map(|pivot| pivot.value);
    let title = format!("[[animation.{kind}]] key");
    let example = "[{ time = 4, translate = [1, 0, 0], rotate_deg = 90 }]";
    let keys = read_keys(&mut section, &title, example, &Key::default(), |key, before| {
        key.allow(&["time", "translate", "rotate_deg"])?;
        let translate = key.vector("translate")?.map_or(before.translate, |found| found.value);
        let rotate_deg = key.number("rotate_deg")?.map_or(before.rotate_deg, |found| found.value);
        Ok(Key { translate, rotate_deg })
    })?;
    let sway = match section.take("sway") {
        Some(sway) => Some(read_sway(Section::new(section.source, "sway", sway)?)?),
        None => None,
    };
    if keys.is_none() && sway.is_none() {
        section.require::<()>("keys", example, None)?;
    }
    let track = keys.map(|keys| Track::new(Key::default(), keys));
    Ok(Body { index, track, axis: unit, pivot, sway, line })
}

fn read_sway(mut section: Section<'_>) -> Result<SwayEntry, SceneError> {
    section.allow(&["amplitude", "period", "foot"])?;
    let amplitude = section.vector("amplitude")?;
    let amplitude = section.require("amplitude", "[0.3, 0, 0]", amplitude)?;
    if amplitude.value.y != 0.0 {
        let message =
            format!("amplitude is {}, expected a horizontal one: its second number 0", amplitude.value);
        return Err(section.fault(amplitude.line, message));
    }
    let period = section.number("period")?;
    let period = section.require("period", "4", period)?;
    if period.value <= 0.0 {
        let message = format!("period is {}, expected seconds above 0", period.value);
        return Err(section.fault(period.line, message));
    }
    let foot = section.number("foot")?.map(|foot| foot.value);
    Ok(SwayEntry { amplitude: amplitude.value, period: period.value, foot, line: section.line })
}

/// Reads the keys of a track, if any; each key inherits values from the one before it.
fn read_keys<'a, T: Copy>(
    section: &mut Section<'a>,
    title: &str,
    example: &str,
    first: &T,
    mut read: impl FnMut(&mut Section<'a>, &T) -> Result<T, SceneError>,
) -> Result<Option<Vec<(f32, T)>>, SceneError> {
    let Some(value) = section.take("keys") else { return Ok(None) };
    let line = section.source.line(value.span().start);
    let DeValue::Array(items) = value.into_inner() else {
        return Err(section.fault(line, format!("keys is no list, expected for example {example}")));
    };
    let mut keys: Vec<(f32, T)> = Vec::with_capacity(items.len());
    for item in items {
        let mut key = Section::new(section.source, title, item)?;
        let (after, before) = keys.last().copied().unwrap_or((0.0, *first));
        // Unknown keys are reported first: a misspelt time is not a missing one.
        let value = read(&mut key, &before)?;
        let time = key.number("time")?;
        let time = key.require("time", "4", time)?;
        if time.value <= after {
            let hint = if keys.is_empty() {
                "; time 0 is the scene as it stands"
            } else {
                ", that of the key before"
            };
            let message = format!("time is {}, expected seconds above {after}{hint}", time.value);
            return Err(key.fault(time.line, message));
        }
        keys.push((time.value, value));
    }
    if keys.is_empty() {
        return Err(section.fault(line, format!("keys is empty, expected for example {example}")));
    }
    Ok(Some(keys))
}
