//! Animation of scenes: the camera, lights and meshes move along keyframed paths, and meshes sway.

mod place;
mod read;
mod sway;
mod track;

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use glam::Vec3;
use halflight_core::scene::{Camera, Mesh, Scene};

pub(crate) use read::AnimationEntry;

use place::Path;
use sway::Sway;
use track::{Mix, Track};

/// Animation of a scene: the `[animation]` of its file.
///
/// Time 0 is the scene as it is loaded. Values, angles included, are interpolated linearly between keys, and
/// constant after the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Animation {
    camera: Option<Track<Camera>>,
    /// Index of a light, and its path.
    lights: Vec<(usize, Path)>,
    meshes: Vec<MeshMotion>,
    videos: Vec<Video>,
}

/// Part of a scene that a `[[mesh]]` makes.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// Range of its vertices in the scene's mesh.
    pub(crate) vertices: Range<usize>,
    /// Range of the lights of its emissive faces in the scene's lights.
    pub(crate) lights: Range<usize>,
}

/// Textures that a light shows one after another, from the first again after the last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Video {
    /// Index of the light.
    pub(crate) light: usize,
    /// Index of the first texture, and number of textures.
    pub(crate) first: u32,
    pub(crate) frames: u32,
    /// Textures a second.
    pub(crate) fps: f32,
}

/// Part of a texture by which times may be rounded down.
const EARLY: f32 = 1e-3;

impl Video {
    /// Index of the texture at `time`, in seconds.
    fn at(&self, time: f32) -> u32 {
        self.first + ((time * self.fps + EARLY).max(0.0) as u32) % self.frames.max(1)
    }
}

/// Motion of a mesh of the scene file: it sways, then moves along its path.
#[derive(Clone, Debug, PartialEq)]
struct MeshMotion {
    /// Range of its vertices in the scene's mesh.
    vertices: Range<usize>,
    sway: Option<Sway>,
    path: Option<Path>,
}

impl Animation {
    /// Animation of a scene whose lights show videos; none where nothing moves.
    pub(crate) fn with_videos(animation: Option<Self>, videos: Vec<Video>) -> Option<Self> {
        match animation {
            None if videos.is_empty() => None,
            None => Some(Self { camera: None, lights: Vec::new(), meshes: Vec::new(), videos }),
            Some(animation) => Some(Self { videos, ..animation }),
        }
    }

    /// Scene at `time`, in seconds; `still` is the scene that the animation was loaded with. Vertices,
    /// triangles and materials keep their indices, so that a BVH over the triangles can be refitted; normals
    /// are transformed exactly.
    pub fn at(&self, still: &Scene, time: f32) -> Scene {
        let mut scene = still.clone();
        if let Some(track) = &self.camera {
            scene.camera = track.at(time);
        }
        for (index, path) in &self.lights {
            if let (Some(light), Some(place)) = (scene.lights.get_mut(*index), path.at(time)) {
                *light = light.transformed(|p| place.point(p), |d| place.direction(d));
            }
        }
        for video in &self.videos {
            let place = scene.lights.get_mut(video.light).and_then(|light| light.texture.as_mut());
            if let Some(place) = place {
                place.index = video.at(time);
            }
        }
        for motion in &self.meshes {
            motion.apply(time, Arc::make_mut(&mut scene.mesh));
        }
        scene
    }

    /// Time of the last key, seconds; 0 where there are none. Swaying never ends.
    pub fn last_key(&self) -> f32 {
        let paths = self.meshes.iter().filter_map(|motion| motion.path.as_ref());
        let paths = self.lights.iter().map(|(_, path)| path).chain(paths).map(Path::end);
        self.camera.iter().map(Track::end).chain(paths).fold(0.0, f32::max)
    }
}

impl fmt::Display for Animation {
    /// Summary of the moving objects and the last key: `camera, 1 light; last key at 8 s`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = |count: usize, one: &str, many: &str| match count {
            0 => None,
            1 => Some(format!("1 {one}")),
            _ => Some(format!("{count} {many}")),
        };
        let what = [
            self.camera.as_ref().map(|_| "camera".to_owned()),
            count(self.lights.len(), "light", "lights"),
            count(self.meshes.len(), "mesh", "meshes"),
            count(self.videos.len(), "video", "videos"),
        ];
        write!(f, "{}", what.into_iter().flatten().collect::<Vec<_>>().join(", "))?;
        match self.last_key() {
            0.0 => Ok(()),
            end => write!(f, "; last key at {end} s"),
        }
    }
}

impl MeshMotion {
    fn apply(&self, time: f32, mesh: &mut Mesh) {
        let vertices = self.vertices.clone();
        // A scene other than the animation's own may be shorter.
        let Some(positions) = mesh.positions.get_mut(vertices.clone()) else { return };
        // A scene of flat surfaces has no normals.
        let normals = mesh.normals.get_mut(vertices).unwrap_or_default();
        if let Some(bend) = self.sway.as_ref().and_then(|sway| sway.at(time)) {
            for (index, position) in positions.iter_mut().enumerate() {
                let mut unused = Vec3::ZERO;
                let normal = normals.get_mut(index).unwrap_or(&mut unused);
                (*position, *normal) = bend.vertex(*position, *normal);
            }
        }
        if let Some(place) = self.path.as_ref().and_then(|path| path.at(time)) {
            positions.iter_mut().for_each(|position| *position = place.point(*position));
            normals.iter_mut().for_each(|normal| *normal = place.direction(*normal));
        }
    }
}

impl Mix for Camera {
    fn mix(self, to: Self, part: f32) -> Self {
        Self {
            eye: self.eye.mix(to.eye, part),
            target: self.target.mix(to.target, part),
            up: self.up.mix(to.up, part),
            fov_y_deg: self.fov_y_deg.mix(to.fov_y_deg, part),
            ..self
        }
    }
}

impl Mix for Vec3 {
    fn mix(self, to: Self, part: f32) -> Self {
        self + (to - self) * part
    }
}

impl Mix for f32 {
    fn mix(self, to: Self, part: f32) -> Self {
        self + (to - self) * part
    }
}
