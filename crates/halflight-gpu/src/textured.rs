//! Textured lights: what they emit, on the device, and the image from visible fractions of red, green and blue.

use glam::Vec3;
use halflight_core::light::AreaLight;
use halflight_core::pattern::{Pattern, PatternKind};
use halflight_core::scene::Scene;
use halflight_cpu::irradiance::Shading;
use halflight_cpu::textured::{SeenTexture, StrataRadiance};

use crate::bindings::Slot;
use crate::buffers::Buffers;
use crate::error::{GpuError, caught};
use crate::frame::Frame;
use crate::memory::Memory;
use crate::needs::{Needs, RECORD};
use crate::pass::{Compiler, Pass, flag, shading_flag};
use crate::program::programs;
use crate::recorder::{Groups, Recorder};
use crate::stats::Timed;
use crate::upsample::Upsample;

programs! {
    CHANNEL: "textured: channel" = channel in "textured/channel";
    COMPOSE: "textured: compose" = compose in "compose", "textured/values";
}

/// Passes that upsample a textured light channel by channel and add it to the image.
#[derive(Debug)]
pub(crate) struct TexturedCompose {
    channels: [Pass; 3],
    compose: Pass,
}

impl TexturedCompose {
    /// Compiles the passes; `smoothed` says that the refiner smooths values.
    ///
    /// # Errors
    /// A shader cannot be read or compiled.
    pub(crate) fn new(compiler: &Compiler, shading: Shading, smoothed: bool) -> Result<Self, GpuError> {
        let pass =
            |channel: f64| compiler.pass(CHANNEL, &[("CHANNEL", channel), ("SMOOTHED", flag(smoothed))]);
        Ok(Self {
            channels: [pass(0.0)?, pass(1.0)?, pass(2.0)?],
            compose: compiler.pass(COMPOSE, &[shading_flag(shading)])?,
        })
    }

    /// Declares values by channel, of the samples that are declared already; `smoothed` as in [`Self::new`].
    pub(crate) fn declare(needs: &mut Needs, smoothed: bool) {
        let samples = needs.records(Slot::Samples);
        needs.declare(Slot::Channels, RECORD * samples * if smoothed { 2 } else { 1 });
        needs.declare(Slot::Planes, 3 * 4 * needs.pixels());
    }

    /// Records the forgetting of the values of the light before.
    pub(crate) fn clear(recorder: &mut Recorder) {
        recorder.clear(Slot::Channels);
    }

    /// Records the addition of the light whose uniforms begin at `first` from samples that have values of all channels.
    pub(crate) fn record(&self, recorder: &mut Recorder, upsample: &Upsample, first: u32, coarsest: u32) {
        let samples = recorder.buffers[Slot::Samples].size() / RECORD;
        let bytes = 4 * recorder.buffers.needs.pixels();
        for (channel, pass) in (0..).zip(&self.channels) {
            recorder.run(pass, Timed::Upsample, first, Groups::Count(samples));
            upsample.record(recorder, first, coarsest);
            let (from, to) = (&recorder.buffers[Slot::Plane], &recorder.buffers[Slot::Planes]);
            recorder.encoder.copy_buffer_to_buffer(from, 0, to, channel * bytes, bytes);
        }
        recorder.run(&self.compose, Timed::Compose, first, Groups::Tiles(0));
    }
}

/// Light samples that a refiner takes.
#[derive(Clone, Debug)]
pub(crate) enum Patterns {
    /// Light samples of these patterns.
    Given(Vec<Pattern>),
    /// Squares of 4 to as many columns, of which the device chooses.
    Squares {
        /// Most columns.
        most: u16,
    },
}

/// Fewest columns of patterns that a device chooses.
const FEWEST: u16 = 4;

/// Emission of textured lights, and its places in [`Slot::Emitted`].
#[derive(Debug)]
pub(crate) struct Emitted {
    /// One a light.
    places: Vec<Option<Place>>,
    /// Contents of the slot; none without textured lights.
    buffer: Option<wgpu::Buffer>,
}

/// Returns whether any light has a texture.
pub(crate) fn has_texture(lights: &[AreaLight]) -> bool {
    lights.iter().any(|light| light.texture.is_some())
}

#[derive(Debug)]
struct Place {
    mean: Vec3,
    /// Index of the first cell.
    cells: u32,
    /// Columns and rows of each pattern, and the index of its first stratum; none where the device chooses.
    strata: Vec<(u32, u32, u32)>,
    /// Index of the first stratum.
    first: u32,
    /// Index of the first texel plus one; 0 where none are uploaded.
    texels: u32,
    /// Width and height of the texture, and 1 where its rows run along the second edge.
    size: [u32; 3],
}

impl Emitted {
    /// Uploads what these lights of a scene emit in the strata of patterns, texels of those that the camera sees and, where `texels` says
    /// so, of all; before glossy surfaces also their means over squares.
    ///
    /// # Errors
    /// The device has no room for so much.
    pub(crate) fn new(
        memory: &Memory,
        scene: &Scene,
        lights: &[AreaLight],
        patterns: &Patterns,
        texels: bool,
    ) -> Result<Self, GpuError> {
        let mut vectors = Vec::new();
        let glossy = scene.mesh.is_glossy();
        let texels = texels || glossy;
        let add =
            |light: &AreaLight| add(&mut vectors, scene, light, patterns, [texels || light.visible, glossy]);
        let places = lights.iter().map(add).collect();
        let bytes: &[u8] = bytemuck::cast_slice(&vectors);
        memory.check(Slot::Emitted.label(), bytes.len() as u64, "smaller textures fit")?;
        let upload = || memory.filled(Slot::Emitted.label(), bytes, wgpu::BufferUsages::STORAGE);
        let buffer = (!bytes.is_empty()).then(|| caught(&memory.device, GpuError::Memory, upload));
        Ok(Self { places, buffer: buffer.transpose()? })
    }

    /// Makes it the contents of its slot.
    pub(crate) fn bind(&self, buffers: &mut Buffers, memory: &Memory) {
        if let Some(buffer) = &self.buffer {
            buffers.replace(memory, Slot::Emitted, buffer.clone());
        }
    }

    /// Returns the uniform of a light with what it emits.
    pub(crate) fn with_texture(&self, number: u32, frame: Frame) -> Frame {
        let Some(Some(place)) = self.places.get(number as usize) else { return frame };
        let known = |&&(columns, rows, _): &&(u32, u32, u32)| {
            (columns, rows) == (frame.pattern.columns, frame.pattern.rows)
        };
        let (first, chosen) = match place.strata.iter().find(known) {
            Some(&(_, _, first)) => (first, 0),
            None => (place.first, 1),
        };
        Frame {
            mean_radiance: place.mean.extend(0.0).to_array(),
            texture: [place.cells + 1, first, chosen, place.texels],
            texture_size: [place.size[0], place.size[1], place.size[2], 0],
            ..frame
        }
    }
}

/// Bits of the fourth component of a first texel, where those of the others say how far behind it their level of means begins: those of normal
/// numbers, which no device takes for 0.
const NORMAL_BITS: u32 = 0x3f80_0000;

/// Adds what a light emits, if it has a texture, with its texels and their means over squares where these are asked for; returns where that lies.
fn add(
    vectors: &mut Vec<[f32; 4]>,
    scene: &Scene,
    light: &AreaLight,
    patterns: &Patterns,
    [texels, squares]: [bool; 2],
) -> Option<Place> {
    let texture = scene.light_texture(light)?;
    let cells = vectors.len() as u32;
    let grids = SeenTexture::SIDES.iter().flat_map(|&side| texture.cells(side, side));
    vectors.extend(grids.map(|mean| mean.to_array()));
    let first = vectors.len() as u32;
    let mut add_strata = |pattern: Pattern| {
        let place = vectors.len() as u32;
        let strata = StrataRadiance::new(&texture, light.radiance, pattern);
        vectors.extend(strata.emissions().map(|emission| emission.to_array()));
        (pattern.columns.into(), pattern.rows.into(), place)
    };
    let strata = match patterns {
        Patterns::Given(given) => given.iter().map(|&pattern| add_strata(pattern)).collect(),
        Patterns::Squares { most } => {
            for side in FEWEST..=*most {
                add_strata(Pattern { kind: PatternKind::Grid, columns: side, rows: side });
            }
            Vec::new()
        }
    };
    let place = vectors.len() as u32 + 1;
    if texels {
        vectors.extend(texture.texels().iter().map(|texel| texel.extend(0.0).to_array()));
    }
    if squares {
        // There are no more levels than texels.
        let first = vectors.len() - texture.texels().len();
        for (texel, place) in vectors[first..].iter_mut().zip(texture.level_places()) {
            texel[3] = f32::from_bits(NORMAL_BITS + place);
        }
        vectors.extend(texture.coarser_levels().iter().map(|mean| mean.extend(0.0).to_array()));
    }
    let [width, height] = texture.size();
    let size = [width, height, texture.is_transposed().into()];
    let mean = texture.mean() * light.radiance;
    Some(Place { mean, cells, strata, first, texels: if texels { place } else { 0 }, size })
}
