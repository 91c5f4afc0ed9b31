//! Textured lights: what they emit, on the device, and the image from visible fractions of red, green and blue.

use glam::Vec3;
use halflight_core::light::AreaLight;
use halflight_core::pattern::{Pattern, PatternKind};
use halflight_core::scene::Scene;
use halflight_cpu::textured::{SeenTexture, StrataRadiance};

use crate::bindings::Slot;
use crate::error::GpuError;
use crate::frame::Frame;
use crate::needs::{Needs, RECORD};
use crate::pass::{Compiler, Pass, flag};
use crate::program::programs;
use crate::recorder::{Groups, Recorder};
use crate::stats::Timed;
use crate::upsample::Upsample;

programs! {
    CHANNEL: "textured: channel" = channel in "textured/channel";
    COMPOSE: "textured: compose" = compose in "textured/compose";
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
    pub(crate) fn new(compiler: &Compiler, smoothed: bool) -> Result<Self, GpuError> {
        let pass =
            |channel: f64| compiler.pass(CHANNEL, &[("CHANNEL", channel), ("SMOOTHED", flag(smoothed))]);
        Ok(Self { channels: [pass(0.0)?, pass(1.0)?, pass(2.0)?], compose: compiler.pass(COMPOSE, &[])? })
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
    /// Those of these patterns.
    Given(Vec<Pattern>),
    /// Squares of 4 to as many columns, of which the device chooses.
    Squares {
        /// Most columns.
        most: u16,
    },
}

/// Fewest columns of patterns that a device chooses.
const FEWEST: u16 = 4;

/// What textured lights emit, and where it lies in [`Slot::Emitted`].
#[derive(Debug, Default)]
pub(crate) struct Emitted {
    /// Contents of the slot.
    pub(crate) vectors: Vec<[f32; 4]>,
    /// One a light.
    places: Vec<Option<Place>>,
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
}

impl Emitted {
    /// Returns what these lights of a scene emit in the strata of patterns.
    pub(crate) fn new(scene: &Scene, lights: &[AreaLight], patterns: &Patterns) -> Self {
        let mut emitted = Self::default();
        for light in lights {
            let place = emitted.add(scene, light, patterns);
            emitted.places.push(place);
        }
        emitted
    }

    fn add(&mut self, scene: &Scene, light: &AreaLight, patterns: &Patterns) -> Option<Place> {
        let texture = scene.light_texture(light)?;
        let cells = self.vectors.len() as u32;
        let grids = SeenTexture::SIDES.iter().flat_map(|&side| texture.cells(side, side));
        self.vectors.extend(grids.map(|mean| mean.to_array()));
        let first = self.vectors.len() as u32;
        let mut add_strata = |pattern: Pattern| {
            let strata = StrataRadiance::new(&texture, light.radiance, pattern);
            self.vectors.extend(strata.emissions().map(|emission| emission.to_array()));
            self.vectors.len() as u32
        };
        let mut strata = Vec::new();
        match patterns {
            Patterns::Given(given) => {
                let mut next = first;
                for &pattern in given {
                    strata.push((pattern.columns.into(), pattern.rows.into(), next));
                    next = add_strata(pattern);
                }
            }
            Patterns::Squares { most } => {
                for side in FEWEST..=*most {
                    add_strata(Pattern { kind: PatternKind::Grid, columns: side, rows: side });
                }
            }
        }
        Some(Place { mean: texture.mean() * light.radiance, cells, strata, first })
    }

    /// Declares the slot.
    pub(crate) fn declare(&self, needs: &mut Needs) {
        needs.declare(Slot::Emitted, RECORD * self.vectors.len() as u64);
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
            texture: [place.cells + 1, first, chosen, 0],
            ..frame
        }
    }
}
