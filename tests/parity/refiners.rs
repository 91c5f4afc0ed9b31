//! Parity of cells and their values.

use std::collections::HashSet;

use halflight::config::{PipelineConfig, RefinerConfig, UpsamplerConfig};
use halflight::fragment::Fragments;
use halflight::irradiance::Shading;
use halflight::refine::{LatticeConfig, NicholsConfig, SfvtGassConfig};
use halflight::values::Values;
use halflight_gpu::Inside;

use crate::device::Bench;
use crate::masks::{gpu_masks, halves};
use crate::scenes::{Twins, per_pixel, values};

/// Refiners with the papers' constants, and with others.
fn refiners() -> Vec<(&'static str, RefinerConfig)> {
    let nichols = NicholsConfig::default();
    let sfvt = SfvtGassConfig::default();
    vec![
        ("nichols", RefinerConfig::Nichols(nichols)),
        ("nichols, traced anew", RefinerConfig::Nichols(NicholsConfig { incremental: false, ..nichols })),
        (
            "nichols, interleaved and diagonal",
            RefinerConfig::Nichols(NicholsConfig {
                interleaved: true,
                diagonal: true,
                visibility_threshold: 0.1,
                coarsest_level: 5,
                ..nichols
            }),
        ),
        ("sfvt-gass", RefinerConfig::SfvtGass(sfvt)),
        (
            "sfvt-gass, other constants",
            RefinerConfig::SfvtGass(SfvtGassConfig {
                inclusive: true,
                dark_culling: false,
                additional_samples: false,
                gradient_threshold: 3,
                coarsest_level: 6,
                ..sfvt
            }),
        ),
    ]
}

/// Levels of pixels, and of the samples at each index: `u32::MAX` where there is none.
struct Cells {
    owners: Vec<u32>,
    /// Samples by level, column and row of their cell (for additional samples: 0 and the pixel), with
    /// position and value.
    samples: Vec<(Key, Found)>,
}

/// Level, column and row.
type Key = (u32, u32, u32);

/// Position, value and pixel.
type Found = ([f32; 2], f32, u32);

/// First index of each level.
fn level_first(width: u32, height: u32, level: u32) -> u32 {
    (0..level).map(|level| width.div_ceil(1 << level) * height.div_ceil(1 << level)).sum()
}

fn cpu_cells(fragments: &Fragments, values: &Values) -> Cells {
    let (width, height) = (fragments.width(), fragments.height());
    let mut owners = vec![u32::MAX; (width * height) as usize];
    let mut samples = Vec::new();
    for cell in fragments.cells() {
        let (x0, y0, x1, y1) = cell.pixels(width, height);
        for y in y0..y1 {
            owners[(y * width + x0) as usize..(y * width + x1) as usize].fill(cell.level.into());
        }
        for (number, &index) in fragments.cell_samples(cell).iter().enumerate() {
            let sample = &fragments.samples()[index as usize];
            let key = match number {
                0 => (u32::from(cell.level), u32::from(cell.x), u32::from(cell.y)),
                _ => (0, sample.pixel % width, sample.pixel / width),
            };
            let value = values.get(0, index as usize).unwrap_or(-1.0);
            samples.push((key, ([sample.x, sample.y], value, sample.pixel)));
        }
    }
    Cells { owners, samples }
}

/// Checks owners and samples; returns the number of pixels in cells of another level, and the number of
/// differing samples.
fn compare(bench: &Bench, twins: &Twins, shading: Shading) -> (usize, usize) {
    let fragments = twins.cpu.fragments();
    let expected = cpu_cells(fragments, &values(twins, shading));
    let owners: Vec<u32> = bench.read(twins.gpu.inside(Inside::Owners));
    let raw: Vec<[u32; 4]> = bench.read(twins.gpu.inside(Inside::Samples));
    let receiver = |pixel: &usize| twins.cpu.gbuffer().is_receiver(*pixel);
    let others = (0..owners.len()).filter(receiver).filter(|&p| owners[p] != expected.owners[p]).count();
    let (width, height) = (fragments.width(), fragments.height());
    let mut differ = 0;
    for ((level, x, y), (at, value, pixel)) in expected.samples {
        let place = level_first(width, height, level) + y * width.div_ceil(1 << level) + x;
        let [ax, ay, v, p] = raw[place as usize];
        let found = [ax, ay, v].map(f32::from_bits);
        // Sums have identical terms and order; divisions may be wrong by 2.5 units in the last place on GPUs.
        let close = (found[2] - value).abs() <= 1e-5 * value.abs();
        if found[..2] != at || !close || p != pixel {
            differ += 1;
        }
    }
    (others, differ)
}

/// Checks cells and their values against those of the CPU; the error lists the differences.
pub(crate) fn check(bench: &Bench, twins: &Twins, shading: Shading) -> Result<(), String> {
    let (others, differ) = compare(bench, twins, shading);
    // One ray in a hundred thousand is within the rounding error of an edge (see `masks`): one or two values
    // of thousands have such a ray. Everything else is identical.
    let (samples, pixels) = (twins.cpu.fragments().samples().len(), twins.cpu.gbuffer().pixels());
    let fits = differ * 1000 <= samples && others * 1000 <= pixels;
    fits.then_some(()).ok_or(format!("{differ} of {samples} samples, {others} of {pixels} pixels"))
}

fn check_scene(bench: &Bench, scene: &'static str, (name, refiner): (&str, RefinerConfig), shading: Shading) {
    let config = PipelineConfig { refiner, ..per_pixel(110, 83, shading) };
    let twins = Twins::render(bench, scene, &config, true);
    check(bench, &twins, shading).unwrap_or_else(|off| panic!("{scene} {name} {shading:?}: {off}"));
}

#[test]
fn cells_and_their_values_are_equal() {
    let Some(bench) = Bench::open() else { return };
    for refiner in refiners() {
        check_scene(&bench, "toys", refiner, Shading::Ratio);
    }
    for scene in ["atrium", "tree"] {
        check_scene(&bench, scene, refiners()[0], Shading::Ratio);
        check_scene(&bench, scene, refiners()[3], Shading::Sampled);
    }
}

#[test]
fn counts_are_those_of_the_cpu() {
    let Some(bench) = Bench::open() else { return };
    for (name, refiner) in refiners() {
        let config = PipelineConfig { refiner, ..per_pixel(97, 61, Shading::Ratio) };
        let mut twins = Twins::render(&bench, "toys", &config, true);
        let expected = &twins.cpu.image().stats;
        let stats = bench.render(
            &mut twins.gpu,
            &halflight_gpu::Inputs { surfaces: halflight_gpu::Surfaces::Kept, ..Default::default() },
        );
        assert_eq!(stats.frame.fragments, expected.fragments, "{name}");
        assert_eq!(stats.frame.rays, expected.rays, "{name}");
    }
}

#[test]
fn the_lattice_is_that_of_the_cpu() {
    let Some(bench) = Bench::open() else { return };
    let cases = [("toys", Shading::Sampled), ("atrium", Shading::Ratio), ("tree", Shading::Ratio)];
    for (scene, shading) in cases {
        let refiner = RefinerConfig::Lattice(LatticeConfig::default());
        let config = PipelineConfig {
            refiner,
            upsampler: UpsamplerConfig::Lattice(Default::default()),
            ..per_pixel(203, 117, shading)
        };
        let twins = Twins::render(&bench, scene, &config, true);
        check_lattice(&bench, &twins, shading).unwrap_or_else(|off| panic!("{scene} {shading:?}: {off}"));
    }
}

/// Checks the cells and values of the lattice; the error lists the differences.
pub(crate) fn check_lattice(bench: &Bench, twins: &Twins, shading: Shading) -> Result<(), String> {
    let (others, differ) = compare_lattice(bench, twins, shading);
    let flips = flipped(bench, twins);
    // A ray that rounding decides differently (see `masks`) may split a cell on one side alone, and
    // neighbouring cells follow.
    let fits = flips <= 4 && others.len() <= 64 * flips && differ.len() <= 64 * flips;
    fits.then_some(()).ok_or(format!("{flips} rays, pixels {others:?}, samples {differ:?}"))
}

/// Number of rays of samples that both sides traced with different visibility.
fn flipped(bench: &Bench, twins: &Twins) -> usize {
    let fragments = twins.cpu.fragments();
    let words = fragments.batch(0).pattern().len().div_ceil(32);
    let found = gpu_masks(bench, &twins.gpu, words);
    let flips = fragments.samples().iter().filter_map(|sample| {
        let (_, wanted, visible) = found.get(&sample.pixel)?;
        let expected = halves(fragments.batch(sample.batch).visible(sample.first as usize));
        let bits = |word: usize| (wanted[word] & (visible[word] ^ expected[word])).count_ones();
        Some((0..words).map(bits).sum::<u32>() as usize)
    });
    flips.sum()
}

/// Column and row of a pixel, and its values on both sides.
type Differing<A, B> = Vec<(u32, u32, A, B)>;

/// Pixels in cells of another level, with both levels, and pixels that are samples on one side alone or have
/// other values.
fn compare_lattice(
    bench: &Bench,
    twins: &Twins,
    shading: Shading,
) -> (Differing<u32, u32>, Differing<Option<f32>, Option<f32>>) {
    let fragments = twins.cpu.fragments();
    let width = fragments.width();
    let expected = cpu_cells(fragments, &Values::default());
    let owners: Vec<u32> = bench.read(twins.gpu.inside(Inside::Owners));
    let others = (0..owners.len())
        .filter(|&pixel| twins.cpu.gbuffer().is_receiver(pixel) && owners[pixel] != expected.owners[pixel])
        .map(|p| (p as u32 % width, p as u32 / width, expected.owners[p], owners[p]))
        .collect();
    let queries: Vec<[u32; 4]> = bench.read(twins.gpu.inside(Inside::Queries));
    let asked: HashSet<u32> = queries.iter().filter(|query| query[2] > 0).map(|query| query[0]).collect();
    let raw: Vec<[u32; 4]> = bench.read(twins.gpu.inside(Inside::Samples));
    let known: HashSet<u32> = fragments.samples().iter().map(|sample| sample.pixel).collect();
    let mut differ: Vec<_> =
        asked.difference(&known).map(|&p| (p % width, p / width, None, Some(f32::NAN))).collect();
    let values = values(twins, shading);
    for (index, sample) in fragments.samples().iter().enumerate() {
        let value = values.get(0, index);
        let (found, p) = (f32::from_bits(raw[sample.pixel as usize][2]), sample.pixel);
        let off = (found - value.unwrap_or(-1.0)).abs();
        let close = off <= 1e-5 * value.unwrap_or(0.0);
        if !asked.contains(&p) || !close {
            differ.push((p % width, p / width, value, asked.contains(&p).then_some(found)));
        }
    }
    (others, differ)
}
