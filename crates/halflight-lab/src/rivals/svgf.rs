//! Spatiotemporal variance-guided filtering without its temporal part: Schied, Kaplanyan, Wyman, Patney, Chaitanya, Burgess,
//! Liu, Dachsbacher, Lefohn, Salvi, "Spatiotemporal Variance-Guided Filtering", HPG 2017. Steps have the sections of that
//! paper.
//!
//! The filtered quantity is the visible fraction of one light, which the pipeline multiplies with the analytic irradiance:
//! illumination without texture, as in §3. Every pixel brings 1 to 4 light samples of its own.
//!
//! 1. Variance in 7 × 7 pixels on the same surface (§4.2, for pixels without history).
//! 2. À-trous passes with 5 × 5 taps that lie 1, 2, 4 … pixels apart, weighted by surface and by the difference of
//!    fractions in standard deviations (§4.3, §4.4). The variance is filtered along.
//!
//! Differences from the paper: depths are compared as distances from the tangent plane, which the G-buffer knows exactly,
//! instead of screen-space gradients; `exp(−x)` is `(1 − x/16)¹⁶`, 0 from 16 on; blocks without variance are copied.

use halflight_core::camera::View;
use halflight_core::fragment::Fragments;
use halflight_core::frame::Frame;
use halflight_core::stages::Upsampler;
use halflight_cpu::multiversion;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Pixels that are filtered together.
const LANES: usize = 16;
/// Largest number of passes.
pub(super) const MAX_PASSES: u32 = 5;
/// Free pixels around the image: the farthest tap of the last pass.
const PAD: usize = 2 << (MAX_PASSES - 1);
/// Half of the taps of a pass along an axis: the middle one and two beside it.
const TAPS: [f32; 3] = [3.0 / 8.0, 1.0 / 4.0, 1.0 / 16.0];
/// Constant σ_z of depths: distance from the tangent plane, in distances between the pixels' surface points. The paper has 1;
/// less leaks less over edges where history is missing.
const DEPTH: f32 = 0.3;

/// Constants of the filter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SvgfConfig {
    /// Light samples a pixel.
    pub samples: u32,
    /// Constant σ_l: difference of two fractions that are filtered together, in standard deviations.
    pub luminance: f32,
    /// Number of passes, 1 to 5. The paper has 5; with 3 errors are least in all scenes that were tried, since history is
    /// missing and the variance of few samples has the shadow's own edges in it.
    pub passes: u32,
}

impl Default for SvgfConfig {
    fn default() -> Self {
        Self { samples: 4, luminance: 4.0, passes: 3 }
    }
}

/// Returns the bytes of the filter's buffers for an image of this size.
pub(super) fn bytes_needed(width: u32, height: u32) -> u64 {
    (u64::from(width) + 3 * PAD as u64) * (u64::from(height) + 2 * PAD as u64) * 12 * 4
}

/// Upsampler that filters the values of a sample a pixel.
pub(super) struct Svgf {
    config: SvgfConfig,
    planes: Planes,
    /// Fractions and variances that a pass writes.
    next: [Vec<f32>; 2],
}

/// Knowledge of each pixel, with free pixels around the image, whose normals are zero: they have no weight.
#[derive(Default)]
struct Planes {
    /// Pixels in a row with its free ones.
    stride: usize,
    fraction: Vec<f32>,
    variance: Vec<f32>,
    /// 1 where there is a value, 0 elsewhere.
    known: Vec<f32>,
    normal: [Vec<f32>; 3],
    position: [Vec<f32>; 3],
    /// 1/m: one over [`DEPTH`] and the distance of neighbouring pixels at the surface's depth.
    density: Vec<f32>,
}

impl Svgf {
    pub(super) fn new(config: SvgfConfig) -> Self {
        Self { config, planes: Planes::default(), next: Default::default() }
    }

    /// Filters and takes over the result.
    fn pass(&mut self, width: usize, kernel: impl Fn(&Planes, usize, &mut [f32], &mut [f32]) + Sync) {
        let Self { planes, next: [fraction, variance], .. } = self;
        let stride = planes.stride;
        let rows = planes.fraction.len() / stride - 2 * PAD;
        let inner = PAD * stride..(PAD + rows) * stride;
        for plane in [&mut *fraction, &mut *variance] {
            plane.clear();
            plane.resize(planes.fraction.len(), 0.0);
        }
        let out = fraction[inner.clone()]
            .par_chunks_exact_mut(stride)
            .zip(variance[inner].par_chunks_exact_mut(stride));
        out.enumerate().for_each(|(row, (fraction, variance))| {
            let first = (PAD + row) * stride + PAD;
            kernel(planes, first, &mut fraction[PAD..PAD + width], &mut variance[PAD..PAD + width]);
        });
        std::mem::swap(fraction, &mut planes.fraction);
        std::mem::swap(variance, &mut planes.variance);
    }
}

impl Upsampler for Svgf {
    fn upsample(&mut self, frame: &Frame, fragments: &Fragments, values: &[f32], out: &mut [f32]) {
        let (width, luminance) = (frame.gbuffer.width as usize, self.config.luminance);
        self.planes.fill(frame, fragments, values);
        // Whole blocks: those at the end of a row reach into the free pixels.
        let padded = width.next_multiple_of(LANES);
        self.pass(padded, moments);
        for pass in 0..self.config.passes {
            self.pass(padded, |planes, first, fraction, variance| {
                atrous(planes, first, 1 << pass, luminance, fraction, variance);
            });
        }
        let Planes { stride, fraction, .. } = &self.planes;
        let rows = fraction.chunks_exact(*stride).skip(PAD);
        for (out, row) in out.chunks_mut(width.max(1)).zip(rows) {
            out.copy_from_slice(&row[PAD..PAD + width]);
        }
    }

    fn bytes(&self) -> usize {
        self.planes.density.capacity() * 12 * size_of::<f32>()
    }
}

impl Planes {
    fn fill(&mut self, frame: &Frame, fragments: &Fragments, values: &[f32]) {
        let seen = frame.gbuffer;
        let (width, height) = (seen.width as usize, seen.height as usize);
        self.stride = width.next_multiple_of(LANES) + 2 * PAD;
        let stride = self.stride;
        let count = stride * (height + 2 * PAD);
        let Self { fraction, variance, known, normal: [nx, ny, nz], position: [x, y, z], density, .. } = self;
        for plane in [fraction, variance, known, nx, ny, nz, x, y, z, density] {
            plane.clear();
            plane.resize(count, 0.0);
        }
        let view = View::new(&frame.scene.camera, seen.width, seen.height);
        let scale = view.down.length() as f32;
        let normals = seen.shading_normals();
        let place = |pixel: usize| (PAD + pixel / width) * stride + PAD + pixel % width;
        for pixel in (0..seen.pixels()).filter(|&pixel| seen.is_receiver(pixel)) {
            let at = place(pixel);
            for (plane, value) in self.normal.iter_mut().zip(normals[pixel].to_array()) {
                plane[at] = value;
            }
            for (plane, value) in self.position.iter_mut().zip(seen.position[pixel].to_array()) {
                plane[at] = value;
            }
            self.density[at] = 1.0 / (DEPTH * scale * seen.depth[pixel]);
        }
        for (sample, value) in fragments.samples().iter().zip(values).filter(|(_, value)| !value.is_nan()) {
            let at = place(sample.pixel as usize);
            (self.fraction[at], self.known[at]) = (*value, 1.0);
        }
    }
}

/// Block of pixels as the middle of a filter.
struct Middle {
    normal: [[f32; LANES]; 3],
    position: [[f32; LANES]; 3],
    density: [f32; LANES],
    fraction: [f32; LANES],
}

#[inline(always)]
fn block(plane: &[f32], at: usize) -> [f32; LANES] {
    let mut out = [0.0; LANES];
    out.copy_from_slice(&plane[at..at + LANES]);
    out
}

#[inline(always)]
fn squared(value: f32, times: u32) -> f32 {
    (0..times).fold(value, |value, _| value * value)
}

impl Middle {
    #[inline(always)]
    fn new(planes: &Planes, at: usize) -> Self {
        let Planes { normal, position, density, fraction, .. } = planes;
        Self {
            normal: [0, 1, 2].map(|axis| block(&normal[axis], at)),
            position: [0, 1, 2].map(|axis| block(&position[axis], at)),
            density: block(density, at),
            fraction: block(fraction, at),
        }
    }

    /// Returns for each pixel the difference of the fraction of the one at `at`, whose distance in the image is `1 / nearness`, and
    /// its weight; `steepness` is the factor of differences of fractions in the exponent.
    #[inline(always)]
    fn tap(
        &self,
        planes: &Planes,
        at: usize,
        nearness: f32,
        steepness: &[f32; LANES],
    ) -> ([f32; LANES], [f32; LANES]) {
        let (mut differences, mut weights) = ([0.0; LANES], [0.0; LANES]);
        let fraction = block(&planes.fraction, at);
        let normal = [0, 1, 2].map(|axis| block(&planes.normal[axis], at));
        let position = [0, 1, 2].map(|axis| block(&planes.position[axis], at));
        for lane in 0..LANES {
            let (mut facing, mut height) = (0.0f32, 0.0f32);
            for axis in 0..3 {
                let own = self.normal[axis][lane];
                facing += own * normal[axis][lane];
                height += own * (position[axis][lane] - self.position[axis][lane]);
            }
            let difference = fraction[lane] - self.fraction[lane];
            let exponent =
                height.abs() * (self.density[lane] * nearness) + difference.abs() * steepness[lane];
            // Constant σ_n of normals: 128.
            let surface = squared(facing.max(0.0), 7);
            weights[lane] = surface * squared((1.0 - exponent * (1.0 / 16.0)).max(0.0), 4);
            differences[lane] = difference;
        }
        (differences, weights)
    }
}

/// Returns the distance in the image, inverted, of a tap.
#[inline(always)]
fn nearness(dx: isize, dy: isize, step: usize) -> f32 {
    1.0 / (((dx * dx + dy * dy) as f32).sqrt() * step as f32)
}

multiversion! {
    /// Estimates the variance of a row of pixels in 7 × 7 of them; pixels without a value get the mean there.
    fn moments(planes: &Planes, first: usize, fraction: &mut [f32], variance: &mut [f32]) {
        const REACH: isize = 3;
        let stride = planes.stride as isize;
        let blocks = fraction.as_chunks_mut::<LANES>().0.iter_mut().zip(variance.as_chunks_mut::<LANES>().0);
        for (number, (fraction, variance)) in blocks.enumerate() {
            let at = first + number * LANES;
            let middle = Middle::new(planes, at);
            let known = block(&planes.known, at);
            *fraction = middle.fraction;
            let even = (-REACH..=REACH).all(|dy| {
                let row = (at as isize + dy * stride - REACH) as usize;
                let row = row..row + LANES + 2 * REACH as usize;
                planes.fraction[row.clone()].iter().all(|&value| value == middle.fraction[0])
                    && planes.known[row].iter().all(|&known| known == 1.0)
            });
            if even {
                continue;
            }
            // The middle itself is one of the values.
            let (mut weight, mut sum, mut squares) = (known, [0.0f32; LANES], [0.0f32; LANES]);
            for dy in -REACH..=REACH {
                for dx in -REACH..=REACH {
                    if (dx, dy) == (0, 0) {
                        continue;
                    }
                    let tap = (at as isize + dy * stride + dx) as usize;
                    let (differences, weights) = middle.tap(planes, tap, nearness(dx, dy, 1), &[0.0; LANES]);
                    let known = block(&planes.known, tap);
                    for lane in 0..LANES {
                        let (w, d) = (weights[lane] * known[lane], differences[lane]);
                        weight[lane] += w;
                        sum[lane] += w * d;
                        squares[lane] += w * d * d;
                    }
                }
            }
            for lane in 0..LANES {
                let share = if weight[lane] > 1e-6 { 1.0 / weight[lane] } else { 0.0 };
                let mean = sum[lane] * share;
                variance[lane] = (squares[lane] * share - mean * mean).max(0.0);
                fraction[lane] += (1.0 - known[lane]) * mean;
            }
        }
    }
}

multiversion! {
    /// Filters a row of pixels with taps that lie `step` pixels apart.
    fn atrous(planes: &Planes, first: usize, step: usize, luminance: f32, fraction: &mut [f32], variance: &mut [f32]) {
        let stride = planes.stride as isize;
        let blocks = fraction.as_chunks_mut::<LANES>().0.iter_mut().zip(variance.as_chunks_mut::<LANES>().0);
        for (number, (fraction, variance)) in blocks.enumerate() {
            let at = first + number * LANES;
            let middle = Middle::new(planes, at);
            *fraction = middle.fraction;
            let deviation = deviations(planes, at);
            if deviation == [0.0; LANES] {
                continue;
            }
            let steepness = deviation.map(|deviation| 1.0 / (luminance * deviation + 1e-6));
            let centre = TAPS[0] * TAPS[0];
            let own = block(&planes.variance, at);
            let (mut weight, mut sum) = ([centre; LANES], [0.0f32; LANES]);
            let mut noise = own.map(|own| centre * centre * own);
            for dy in -2isize..=2 {
                for dx in -2isize..=2 {
                    if (dx, dy) == (0, 0) {
                        continue;
                    }
                    let tap = (at as isize + (dy * stride + dx) * step as isize) as usize;
                    let share = TAPS[dx.unsigned_abs()] * TAPS[dy.unsigned_abs()];
                    let (differences, weights) = middle.tap(planes, tap, nearness(dx, dy, step), &steepness);
                    let other = block(&planes.variance, tap);
                    for lane in 0..LANES {
                        let w = share * weights[lane];
                        weight[lane] += w;
                        sum[lane] += w * differences[lane];
                        noise[lane] += w * w * other[lane];
                    }
                }
            }
            for lane in 0..LANES {
                let share = 1.0 / weight[lane];
                fraction[lane] += sum[lane] * share;
                variance[lane] = noise[lane] * share * share;
            }
        }
    }
}

/// Returns the standard deviations of a block of pixels, their variances blurred over 3 × 3 pixels (§4.4).
#[inline(always)]
fn deviations(planes: &Planes, at: usize) -> [f32; LANES] {
    let mut blurred = [0.0f32; LANES];
    for (row, down) in [0.25, 0.5, 0.25].into_iter().enumerate() {
        for (column, across) in [0.25, 0.5, 0.25].into_iter().enumerate() {
            let values = block(&planes.variance, at + row * planes.stride + column - planes.stride - 1);
            for lane in 0..LANES {
                blurred[lane] += down * across * values[lane];
            }
        }
    }
    blurred.map(f32::sqrt)
}
