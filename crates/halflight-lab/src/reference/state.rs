//! The sums of a reference in progress, in memory and on disk.

use std::hash::Hasher as _;
use std::ops::Range;
use std::path::Path;

use fnv::FnvHasher;
use glam::Vec2;
use halflight_core::light::{AreaLight, LightFrame, Shape};
use halflight_core::scene::Scene;
use halflight_metrics::{WriteError, check_output, write_file};

use super::{PASS, ReferenceConfig, ReferenceError};

/// First bytes of every state file; changed whenever older sums would not be continued in the same way.
const MAGIC: [u8; 8] = *b"HLREF 1\n";

/// Number of bytes before the sums: magic, key, passes, pixels, planes.
const HEADER: usize = 40;

/// Planes of a light's sums: one, or those of red, green and blue of a textured light.
pub(super) fn planes(scene: &Scene, light: usize) -> Range<usize> {
    let channels = |light: &AreaLight| if light.texture.is_some() { 3 } else { 1 };
    let first = scene.lights[..light].iter().map(channels).sum();
    first..first + scene.lights.get(light).map_or(0, channels)
}

/// `[Σ l g V, Σ g]` of every pixel, for each half and plane; `l` are the texels of a textured light, else 1.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct State {
    /// Hash of the image that the sums belong to.
    key: u64,
    /// Number of passes added so far.
    pub(super) passes: u32,
    pixels: usize,
    planes: usize,
    totals: Vec<[f64; 2]>,
}

impl State {
    pub(super) fn new(key: u64, pixels: usize, planes: usize) -> Self {
        Self { key, passes: 0, pixels, planes, totals: vec![[0.0; 2]; 2 * planes * pixels] }
    }

    pub(super) fn totals(&self, half: usize, plane: usize) -> &[[f64; 2]] {
        &self.totals[(half * self.planes + plane) * self.pixels..][..self.pixels]
    }

    pub(super) fn totals_mut(&mut self, half: usize, plane: usize) -> &mut [[f64; 2]] {
        &mut self.totals[(half * self.planes + plane) * self.pixels..][..self.pixels]
    }

    /// Makes the folder of a state, and makes sure that the state can be saved in it.
    pub(super) fn check_path(path: &Path) -> Result<(), ReferenceError> {
        if let Some(folder) = path.parent() {
            fs_err::create_dir_all(folder)
                .map_err(|source| WriteError { path: folder.to_owned(), source })?;
        }
        Ok(check_output(path)?)
    }

    pub(super) fn save(&self, path: &Path) -> Result<(), ReferenceError> {
        let numbers = [self.key, u64::from(self.passes), self.pixels as u64, self.planes as u64];
        let totals = self.totals.as_flattened();
        let mut content = Vec::with_capacity(HEADER + 8 * totals.len() + 8);
        content.extend(MAGIC);
        content.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        content.extend(totals.iter().flat_map(|total| total.to_le_bytes()));
        let mut check = FnvHasher::default();
        check.write(&content);
        content.extend(check.finish().to_le_bytes());
        Ok(write_file(path, &content)?)
    }

    /// Takes over the sums saved in a file, if there is one.
    pub(super) fn load(&mut self, path: &Path) -> Result<(), ReferenceError> {
        let fault = |message: String| Err(ReferenceError::State { path: path.to_owned(), message });
        let bytes = match std::fs::read(path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(()),
            Err(error) => return fault(error.to_string()),
        };
        let Some(saved) = Self::decode(&bytes) else {
            return fault("it is damaged or from another version".to_owned());
        };
        if (saved.key, saved.pixels, saved.planes) != (self.key, self.pixels, self.planes) {
            return fault("it belongs to another image".to_owned());
        }
        *self = saved;
        Ok(())
    }

    fn decode(bytes: &[u8]) -> Option<Self> {
        let (content, check) = bytes.split_last_chunk::<8>()?;
        let mut expected = FnvHasher::default();
        expected.write(content);
        if u64::from_le_bytes(*check) != expected.finish() || !content.starts_with(&MAGIC) {
            return None;
        }
        let (header, totals) = content.split_at_checked(HEADER)?;
        let number = |index: usize| -> Option<u64> {
            Some(u64::from_le_bytes(*header.get(8 + 8 * index..)?.first_chunk()?))
        };
        let (key, passes) = (number(0)?, u32::try_from(number(1)?).ok()?);
        let (pixels, planes) = (usize::try_from(number(2)?).ok()?, usize::try_from(number(3)?).ok()?);
        let expected = pixels.checked_mul(planes)?.checked_mul(2 * size_of::<[f64; 2]>())?;
        if totals.len() != expected {
            return None;
        }
        let (numbers, _) = totals.as_chunks::<8>();
        let numbers: Vec<f64> = numbers.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
        let (totals, _) = numbers.as_chunks::<2>();
        Some(Self { key, passes, pixels, planes, totals: totals.to_vec() })
    }
}

/// Returns a hash of all that a reference's samples depend on: equal on every machine and with every compiler. Materials
/// are left out, since irradiance does not depend on them, but for their alpha masks.
pub(super) fn key(scene: &Scene, config: &ReferenceConfig) -> u64 {
    let mut hash = FnvHasher::default();
    let mut words = |values: &[u32]| values.iter().for_each(|value| hash.write(&value.to_le_bytes()));
    words(&[PASS, config.width, config.height, config.seed]);
    words(&[scene.mesh.positions.len() as u32, scene.mesh.triangles.len() as u32, scene.lights.len() as u32]);
    for position in &scene.mesh.positions {
        words(&position.to_array().map(f32::to_bits));
    }
    // Flat meshes have none.
    for normal in &scene.mesh.normals {
        words(&normal.to_array().map(f32::to_bits));
    }
    words(scene.mesh.triangles.as_flattened());
    for triangle in 0..scene.mesh.triangle_count() {
        if let Some(mask) = scene.mesh.alpha_mask(triangle) {
            words(&[triangle as u32, mask.width(), mask.height()]);
            words(scene.mesh.materials[scene.mesh.material_ids[triangle] as usize].alpha_mask.as_slice());
            for &vertex in &scene.mesh.triangles[triangle] {
                words(&scene.mesh.uvs[vertex as usize].to_array().map(f32::to_bits));
            }
        }
    }
    for mask in &scene.mesh.alpha_masks {
        for &word in mask.words() {
            words(&[word as u32, (word >> 32) as u32]);
        }
    }
    for light in &scene.lights {
        let LightFrame { origin, u, v } = light.frame();
        for vector in [origin, u, v, light.radiance] {
            words(&vector.to_array().map(f32::to_bits));
        }
        match light.shape {
            Shape::Parallelogram(_) => {}
            Shape::Ellipse(_) => words(&[1]),
            Shape::Sphere(_) => words(&[3]),
            Shape::Polygon(polygon) => {
                words(&[2, polygon.corners().len() as u32]);
                for corner in polygon.corners() {
                    words(&corner.to_array().map(f32::to_bits));
                }
            }
        }
        words(&[u32::from(light.two_sided)]);
        if let Some(place) = light.texture {
            words(&[u32::from(place.transposed)]);
            let texture = scene.light_textures.get(place.index as usize);
            words(&texture.map_or([0; 2], |texture| [texture.width(), texture.height()]));
            for texel in texture.into_iter().flat_map(|texture| texture.texels()) {
                words(&texel.to_array().map(f32::to_bits));
            }
        }
    }
    let camera = &scene.camera;
    for vector in [camera.eye, camera.target, camera.up] {
        words(&vector.to_array().map(f32::to_bits));
    }
    words(&[camera.fov_y_deg.to_bits()]);
    // States of centred cameras keep their names.
    if camera.shift != Vec2::ZERO || camera.aspect.is_some() {
        words(&camera.shift.to_array().map(f32::to_bits));
        words(&[camera.aspect.unwrap_or_default().to_bits()]);
    }
    hash.finish()
}
