//! Specular reflection of lights: what a pixel's lobe reflects without occluders, times the visible part of that.
//!
//! 1. The light is parted into cells that are small beside the lobe; their sum is what is reflected without occluders (`cells`).
//! 2. Where the refiner found all samples of a cell of the image lit, or all unlit, so is what the lobe reflects.
//! 3. Elsewhere shadow rays go to points of the light, distributed as the lobe reflects it, and the visible fraction is the part that arrives (`visible`).
//!
//! A visible fraction of the diffuse light would not do: a lobe looks at another part of the light, often a small one.

mod cells;
mod lobe;
#[cfg(test)]
mod tests;
mod visible;

use glam::Vec3;
use halflight_core::fragment::Fragments;
use halflight_core::frame::Frame;
use halflight_core::gbuffer::GBuffer;
use halflight_core::hash;
use halflight_core::specular::SurfaceSpecular;
use halflight_core::values::Values;
use rayon::prelude::*;

use crate::bvh::Bvh;
use crate::pool::Pool;
use crate::segments::Occluders;
use cells::{Cells, Emitter, Outline};
use lobe::Lobe;
use visible::Tracer;

/// Pixels that one task looks at.
const TASK: usize = 256;

/// Least and most shadow rays of a lobe.
const LEAST_RAYS: usize = 16;
const MOST_RAYS: usize = 4096;

/// Distinguishes the random numbers of lobes from those of light samples.
const LOBES: u32 = 0x5bec_0a11;

/// Knowledge of a pixel's lobe before any ray.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Known {
    Lit,
    Dark,
    Open,
}

/// Working memory of a task.
#[derive(Default)]
struct Scratch {
    cells: Cells,
    tracer: Tracer,
}

/// Specular light of a frame, in buffers that are kept.
#[derive(Default)]
pub(crate) struct Specular {
    known: Vec<Known>,
    /// Visible fractions of what the lobes of the pixels reflect of the last light, by channel.
    visible: Vec<Vec3>,
    pool: Pool<Scratch>,
}

/// One light of a frame and what hides it.
pub(crate) struct LobeLight<'a> {
    bvh: &'a Bvh,
    frame: &'a Frame<'a>,
    number: u32,
    outline: Outline,
    /// Most rays of a lobe.
    rays: usize,
}

impl<'a> LobeLight<'a> {
    /// A light of a frame whose `fragments` are known. `bvh` is the one over its mesh. Lobes have half as many rays as the largest of the fragments' masks
    /// has light samples, since they look at what they reflect alone, but no fewer than were asked for.
    pub(crate) fn new(bvh: &'a Bvh, frame: &'a Frame<'a>, number: u32, fragments: &Fragments) -> Self {
        let largest = fragments.batches().iter().map(|batch| batch.pattern().len()).max();
        let rays = (largest.unwrap_or(0) / 2).max(frame.pattern.len());
        Self { bvh, frame, number, outline: Outline::new(frame.light(number)), rays }
    }

    /// Specular radiance of an entry of a G-buffer, W/m²/sr, and the visible fraction of what its lobe reflects, which is traced unless it is
    /// known. Returns also the number of rays.
    fn reflected(
        &self,
        gbuffer: &GBuffer,
        entry: usize,
        known: Option<Vec3>,
        key: u32,
        scratch: &mut Scratch,
    ) -> (Vec3, Vec3, u64) {
        let nothing = (Vec3::ZERO, Vec3::ZERO, 0);
        let surface = gbuffer.specular.get(entry).copied().unwrap_or(SurfaceSpecular::MATTE);
        let (light, texture) = (self.frame.light(self.number), self.frame.light_texture(self.number));
        let origin = gbuffer.position[entry];
        if surface.is_matte() || known == Some(Vec3::ZERO) {
            return nothing;
        }
        // Lobes inside a sphere light reflect nothing of it (docs/lights.md).
        if light.surrounds(origin) {
            return nothing;
        }
        let seen = light.seen_from(origin);
        let Some(emitter) = Emitter::new(&seen, &self.outline, texture.as_ref(), origin) else {
            return nothing;
        };
        let emitter = emitter.of_sphere(light.as_sphere(), origin);
        let view = (self.frame.scene.camera.eye - origin).normalize_or_zero();
        let lobe = Lobe::new(gbuffer.shading_normals()[entry], view, &surface);
        let shares = scratch.cells.part(&emitter, &lobe);
        let unshadowed = light.radiance * (surface.f0 * shares.normal + shares.grazing);
        if scratch.cells.share <= 0.0 {
            return nothing;
        }
        let (visible, rays) = match known {
            Some(visible) => (visible, 0),
            None => {
                let count = self.rays.clamp(LEAST_RAYS, MOST_RAYS);
                let occluders = Occluders { bvh: self.bvh, mesh: &self.frame.scene.mesh };
                scratch.tracer.visible(occluders, &emitter, &lobe, &scratch.cells, origin, count, key)
            }
        };
        (unshadowed * visible, visible, rays)
    }
}

impl Specular {
    /// Adds the specular radiance of one light, W/m²/sr, to `out`. `values` are the values of the samples of `fragments`; `fractions` tells that
    /// they are visible fractions. Returns the number of shadow rays.
    pub(crate) fn add_light(
        &mut self,
        light: &LobeLight,
        fragments: &Fragments,
        values: &Values,
        fractions: bool,
        out: &mut [Vec3],
    ) -> u64 {
        let frame = light.frame;
        let Self { known, visible, pool } = self;
        known.clear();
        known.resize(out.len(), Known::Open);
        if fractions {
            look_up(fragments, values, known);
        }
        visible.resize(out.len(), Vec3::ZERO);
        let tasks = out.par_chunks_mut(TASK).zip(visible.par_chunks_mut(TASK)).zip(known.par_chunks(TASK));
        let task = |task: usize, out: &mut [Vec3], visible: &mut [Vec3], known: &[Known]| {
            pool.lend(Scratch::default, |scratch| {
                let mut rays = 0;
                for (place, known) in known.iter().enumerate() {
                    let pixel = task * TASK + place;
                    let known = match known {
                        Known::Lit => Some(Vec3::ONE),
                        Known::Dark => Some(Vec3::ZERO),
                        Known::Open => None,
                    };
                    let key = key(frame, light.number, pixel as u32, 0);
                    let (radiance, part, traced) = light.reflected(frame.gbuffer, pixel, known, key, scratch);
                    out[place] += radiance;
                    visible[place] = part;
                    rays += traced;
                }
                rays
            })
        };
        tasks.enumerate().map(|(number, ((out, visible), known))| task(number, out, visible, known)).sum()
    }

    /// Specular radiance of a sub-sample, which takes its visible fraction from `pixel` or, without one, traces its own.
    pub(crate) fn sub_sample(
        &self,
        light: &LobeLight,
        samples: &GBuffer,
        entry: usize,
        pixel: Option<usize>,
    ) -> (Vec3, u64) {
        let known = pixel.map(|pixel| self.visible[pixel]);
        let key = key(light.frame, light.number, entry as u32, 1);
        let found =
            self.pool.lend(Scratch::default, |scratch| light.reflected(samples, entry, known, key, scratch));
        (found.0, found.2)
    }

    /// Memory held, bytes, without that of running tasks.
    pub(crate) fn bytes(&self) -> usize {
        self.known.capacity() * size_of::<Known>() + self.visible.capacity() * size_of::<Vec3>()
    }
}

fn key(frame: &Frame, light: u32, place: u32, kind: u32) -> u32 {
    hash::fold(hash::pattern_key(place, light, frame.index, frame.seed), LOBES + kind)
}

/// Writes what the cells of the image tell of their pixels: lit or dark where all samples of a cell are.
fn look_up(fragments: &Fragments, values: &Values, known: &mut [Known]) {
    let of = |sample: u32| {
        let mut channels = (0..values.channels()).map(|channel| values.channel(channel)[sample as usize]);
        let first = channels.next().unwrap_or(f32::NAN);
        let alike = channels.all(|value| value == first);
        match first {
            1.0 if alike => Known::Lit,
            0.0 if alike => Known::Dark,
            _ => Known::Open,
        }
    };
    let (width, height) = (fragments.width(), fragments.height());
    for cell in fragments.cells() {
        let samples = fragments.cell_samples(cell);
        let Some(first) = samples.first().map(|&sample| of(sample)) else { continue };
        if first == Known::Open || samples.iter().any(|&sample| of(sample) != first) {
            continue;
        }
        let (x0, y0, x1, y1) = cell.pixels(width, height);
        for y in y0..y1 {
            let row = (y * width) as usize;
            known[row + x0 as usize..row + x1 as usize].fill(first);
        }
    }
}
