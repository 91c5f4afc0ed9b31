//! Decisions of refiners on synthetic masks and images.

use glam::Vec3;
use halflight_core::fragment::{Fragments, Sample};
use halflight_core::frame::{Frame, Sharing};
use halflight_core::gbuffer::{GBuffer, NO_PRIMITIVE};
use halflight_core::light::AreaLight;
use halflight_core::mask::{MaskBatch, Purpose};
use halflight_core::pattern::{Pattern, PatternKind};
use halflight_core::pyramid::Pyramid;
use halflight_core::scene::Scene;
use halflight_core::stages::{RefineOutput, Refiner, Visibility};
use halflight_core::values::Values;

use super::representative::fragment_point;
use super::sfvt_gass::Verdict;
use super::*;
use crate::bvh::Bvh;
use crate::irradiance::{self, Shading};
use crate::requests::Requests;

const SIXTEEN: Pattern = Pattern { kind: PatternKind::Grid, columns: 4, rows: 4 };

/// Floor that fills the image, under a square light.
struct Floor {
    scene: Scene,
    gbuffer: GBuffer,
    pyramid: Pyramid,
}

impl Floor {
    fn new(width: u32, height: u32) -> Self {
        let corner = Vec3::new(-1.0, 4.0, -1.0);
        let light = AreaLight::parallelogram(corner, Vec3::X * 2.0, Vec3::Z * 2.0, Vec3::ONE);
        let mut gbuffer = GBuffer::default();
        gbuffer.reset(width, height);
        gbuffer.depth.fill(1.0);
        gbuffer.normal.fill(Vec3::Y);
        gbuffer.primitive.fill(0);
        for pixel in 0..gbuffer.pixels() {
            let (x, y) = (pixel as u32 % width, pixel as u32 / width);
            gbuffer.position[pixel] = Vec3::new(x as f32 / 64.0 - 1.0, 0.0, y as f32 / 64.0 - 1.0);
        }
        let mut pyramid = Pyramid::default();
        crate::pyramid::build(&gbuffer, 7, &mut pyramid);
        Self { scene: Scene { lights: vec![light], ..Scene::default() }, gbuffer, pyramid }
    }

    fn frame(&self) -> Frame<'_> {
        Frame {
            scene: &self.scene,
            gbuffer: &self.gbuffer,
            pyramid: &self.pyramid,
            pattern: Pattern { kind: PatternKind::Grid, columns: 8, rows: 8 },
            sharing: Sharing::Frame,
            index: 0,
            seed: 0,
        }
    }

    fn refine(&self, refiner: &mut dyn Refiner, seen: impl Fn(u32, u32) -> u64 + Send) -> (Fragments, u64) {
        let (fragments, rays, _) = self.refine_known(refiner, seen);
        (fragments, rays)
    }

    /// Fragments, rays and the fractions that the refiner hands on.
    fn refine_known(
        &self,
        refiner: &mut dyn Refiner,
        seen: impl Fn(u32, u32) -> u64 + Send,
    ) -> (Fragments, u64, Vec<f32>) {
        let mut painted = Painted { seen, rays: 0 };
        let (fragments, known) = self.refine_by(refiner, &mut painted);
        (fragments, painted.rays, known)
    }

    /// Fragments and the fractions that the refiner hands on.
    fn refine_by(&self, refiner: &mut dyn Refiner, visibility: &mut dyn Visibility) -> (Fragments, Vec<f32>) {
        let mut fragments = Fragments::default();
        fragments.reset(self.gbuffer.width, self.gbuffer.height, 0);
        let bvh = Bvh::build(&self.scene.mesh).unwrap();
        let known = refiner
            .refine(&self.frame(), 0, &mut Requests::new(visibility, &bvh), &mut fragments)
            .fractions
            .to_vec();
        fragments.validate(&self.gbuffer).unwrap();
        (fragments, known)
    }
}

/// Synthetic visibility: a function gives the mask of each pixel.
struct Painted<F> {
    seen: F,
    rays: u64,
}

impl<F: Fn(u32, u32) -> u64 + Send> Visibility for Painted<F> {
    fn masks(&mut self, frame: &Frame, batch: &mut MaskBatch) {
        let words = batch.words();
        let (queries, wanted, visible) = batch.slots_mut();
        for (index, query) in queries.iter().enumerate() {
            let (x, y) = (query.pixel % frame.gbuffer.width, query.pixel / frame.gbuffer.width);
            let seen = (self.seen)(x, y);
            for word in index * words..(index + 1) * words {
                self.rays += u64::from(wanted[word].count_ones());
                visible[word] = wanted[word] & seen;
            }
        }
    }
}

/// Verdict on one fragment whose quadrants have these masks.
fn verdict(config: SfvtGassConfig, level: u8, masks: [u16; 4]) -> Verdict {
    let mut fragments = Fragments::default();
    fragments.reset(8, 8, 0);
    let batch = fragments.open_batch(SIXTEEN, Purpose::Refine);
    for mask in masks {
        fragments.batch_mut(batch).push(Vec3::ZERO, Vec3::Y, 0, 0, None);
        let (queries, _, visible) = fragments.batch_mut(batch).slots_mut();
        visible[queries.len() - 1] = u64::from(mask);
    }
    SfvtGass::new(config).verdict(fragments.batch(batch), 0, 4, level)
}

#[test]
fn a_fragment_splits_when_more_bits_differ_than_the_threshold() {
    let paper = SfvtGassConfig::default();
    let inclusive = SfvtGassConfig { inclusive: true, ..paper };
    let all = 0xffff;
    assert_eq!(verdict(paper, 2, [0; 4]), Verdict::Dark);
    assert_eq!(verdict(SfvtGassConfig { dark_culling: false, ..paper }, 2, [0; 4]), Verdict::Stable);
    assert_eq!(verdict(paper, 2, [all; 4]), Verdict::Stable);
    // Two bits, one of them only between the diagonal quadrants A and D: level 2 tolerates two, level 3 one.
    let two = [all, all ^ 1, all, all ^ 2];
    assert_eq!(verdict(paper, 2, two), Verdict::Stable);
    assert_eq!(verdict(inclusive, 2, two), Verdict::Split(0));
    assert_eq!(verdict(paper, 3, two), Verdict::Split(0));
    assert_eq!(verdict(paper, 3, [all, all ^ 1, all, all]), Verdict::Stable);
    assert_eq!(verdict(inclusive, 3, [all, all ^ 1, all, all]), Verdict::Split(0));
    // Equal masks of a penumbra are stable, however few samples are visible.
    assert_eq!(verdict(paper, 4, [0x0f0f; 4]), Verdict::Stable);
}

#[test]
fn steep_gradients_split_both_their_quadrants_two_levels_down() {
    let paper = SfvtGassConfig::default();
    // Quadrants in rows: A B / C D; the ring is A-B, B-D, D-C, C-A.
    assert_eq!(verdict(paper, 3, [0xffff, 0x00ff, 0xffff, 0x00ff]), Verdict::Split(0b1111));
    assert_eq!(
        verdict(paper, 3, [0xffff, 0xff80, 0xffff, 0xff80]),
        Verdict::Split(0),
        "seven bits are not above seven"
    );
    // Only A differs strongly: A-B and A-C are steep, D stays.
    assert_eq!(verdict(paper, 3, [0x00ff, 0xffff, 0xffff, 0xffff]), Verdict::Split(0b0111));
    let koa16 = SfvtGassConfig { gradient_threshold: 4, coarse_threshold: 1, fine_threshold: 1, ..paper };
    assert_eq!(verdict(koa16, 3, [0xffff, 0xff80, 0xffff, 0xff80]), Verdict::Split(0b1111));
}

#[test]
fn sharing_deals_every_sample_out_once() {
    for (columns, rows) in [(4, 4), (8, 8), (2, 2), (7, 1), (1, 5), (5, 3)] {
        let pattern = Pattern { kind: PatternKind::Grid, columns, rows };
        let mut counts = [0; 4];
        for sample in 0..pattern.len() {
            counts[quarter(pattern, sample)] += 1;
        }
        assert_eq!(counts.iter().sum::<usize>(), pattern.len());
        if columns % 2 == 0 && rows % 2 == 0 {
            assert_eq!(counts, [pattern.len() / 4; 4]);
        }
    }
}

#[test]
fn fragments_are_evaluated_right_of_and_below_their_centre() {
    let mut gbuffer = Floor::new(10, 6).gbuffer;
    let at = |gbuffer: &GBuffer, x, y| Some(gbuffer.index(x, y));
    assert_eq!(fragment_point(&gbuffer, 0, 0, 4), at(&gbuffer, 2, 2));
    assert_eq!(fragment_point(&gbuffer, 0, 0, 1), at(&gbuffer, 0, 0));
    // The centre of a clipped fragment is clamped into the image.
    assert_eq!(fragment_point(&gbuffer, 8, 4, 8), at(&gbuffer, 9, 5));
    assert_eq!(fragment_point(&gbuffer, 10, 0, 2), None);
    // Centre without a receiver: the nearest one of the square, or none.
    for (x, y) in [(2, 2), (1, 2), (2, 1), (3, 2), (2, 3)] {
        let pixel = gbuffer.index(x, y);
        gbuffer.primitive[pixel] = NO_PRIMITIVE;
    }
    assert_eq!(fragment_point(&gbuffer, 0, 0, 4), at(&gbuffer, 1, 1));
    gbuffer.primitive.fill(NO_PRIMITIVE);
    assert_eq!(fragment_point(&gbuffer, 0, 0, 4), None);
}

#[test]
fn an_open_floor_stays_coarse_and_a_shadow_edge_is_followed_to_pixels() {
    let floor = Floor::new(256, 128);
    let (open, rays) = floor.refine(&mut SfvtGass::default(), |_, _| u64::MAX);
    // Two fragments of 128², 64 rays each, and three additional samples of 64 each.
    assert_eq!((open.cells().len(), open.samples().len(), rays), (2, 8, 2 * 64 + 6 * 64));
    let (edge, _) = floor.refine(&mut SfvtGass::default(), |x, _| if x < 101 { 0 } else { u64::MAX });
    let on_edge = |fragments: &Fragments, x: u32| {
        let inside = |(x0, _, x1, _): (u32, u32, u32, u32)| (x0..x1).contains(&x);
        fragments.cells().iter().filter(|cell| inside(cell.pixels(256, 128))).map(|cell| cell.level).max()
    };
    assert_eq!((on_edge(&edge, 100), on_edge(&edge, 101)), (Some(0), Some(0)));
    assert!(on_edge(&edge, 200) >= Some(5), "far from the edge fragments stay large");
    let (open, rays) = floor.refine(&mut Nichols::default(), |_, _| u64::MAX);
    assert_eq!((open.cells().len(), rays), (16 * 8, 16 * 8 * 64));
    let (edge, _) = floor.refine(&mut Nichols::default(), |x, _| if x < 101 { 0 } else { u64::MAX });
    assert_eq!((on_edge(&edge, 100), on_edge(&edge, 101)), (Some(0), Some(0)));
    assert_eq!(on_edge(&edge, 200), Some(4));
}

#[test]
fn incremental_and_interleaved_sampling_trace_less_of_the_same_shadow() {
    let floor = Floor::new(128, 128);
    let rays = |incremental, interleaved| {
        let config = NicholsConfig { incremental, interleaved, ..NicholsConfig::default() };
        // Three quarters of the samples are hidden in a disc; on the others every neighbourhood agrees.
        let seen = |x: u32, y: u32| if x * x + y * y < 5000 { 0xff00_ff00 } else { u64::MAX };
        let (fragments, rays) = floor.refine(&mut Nichols::new(config), seen);
        for sample in fragments.samples() {
            let (x, y) = (sample.pixel % 128, sample.pixel / 128);
            let batch = fragments.batch(sample.batch);
            let (wanted, visible) =
                (batch.wanted(sample.first as usize)[0], batch.visible(sample.first as usize)[0]);
            let asked = if interleaved { 16 } else { 64 };
            assert_eq!(wanted.count_ones(), asked, "every sample knows all that it asked for");
            assert_eq!(visible, wanted & seen(x, y), "pixel {x},{y}");
        }
        rays
    };
    let all = rays(false, false);
    assert!(rays(true, false) < all);
    assert!(rays(false, true) < all / 2);
    assert!(rays(true, true) <= rays(false, true));
}

#[test]
fn culled_fragments_hold_no_probes() {
    let mut floor = Floor::new(64, 64);
    floor.gbuffer.normal.fill(-Vec3::Y);
    for name in ["nichols", "sfvt-gass", "lattice"] {
        let mut refiner =
            <crate::config::RefinerConfig as crate::config::Named>::named(name).unwrap().stage();
        let (fragments, rays) = floor.refine(refiner.as_mut(), |_, _| u64::MAX);
        assert_eq!(rays, 0, "{name}");
        // The lattice traces its corners in any case.
        let empty = |sample: &Sample| sample.probes == 0 || name == "lattice";
        assert!(fragments.samples().iter().all(empty) && !fragments.cells().is_empty());
    }
}

/// The first `count` of 64 samples.
fn first(count: u32) -> u64 {
    if count >= 64 { u64::MAX } else { (1 << count) - 1 }
}

/// Visible fraction of each pixel, where it is known.
fn fractions(floor: &Floor, fragments: &Fragments) -> Vec<Option<f32>> {
    let mut known = vec![None; floor.gbuffer.pixels()];
    for sample in fragments.samples() {
        let place = &mut known[sample.pixel as usize];
        assert!(place.is_none(), "pixel {} was traced twice", sample.pixel);
        let batch = fragments.batch(sample.batch);
        *place = irradiance::fraction(&floor.scene.lights[0], batch, sample.first as usize);
    }
    known
}

/// Levels of the cells along a row, by column.
fn levels_of_row(floor: &Floor, fragments: &Fragments, y: u32) -> Vec<u8> {
    let mut owners = Vec::new();
    fragments.owners(&mut owners);
    let row = floor.gbuffer.index(0, y)..floor.gbuffer.index(0, y + 1);
    owners[row].iter().map(|&owner| fragments.cells()[owner as usize].level).collect()
}

#[test]
fn the_lattice_shares_corners_and_refines_what_it_cannot_predict() {
    let floor = Floor::new(256, 128);
    let coarse = LatticeConfig { coarsest_level: 4, ..LatticeConfig::default() };
    let (open, rays) = floor.refine(&mut Lattice::new(coarse), |_, _| u64::MAX);
    // One corner per cell of 16², and one more per row and column, in the image's last pixels.
    assert_eq!((open.cells().len(), open.samples().len(), rays), (16 * 8, 17 * 9, 17 * 9 * 64));
    fractions(&floor, &open);

    let (edge, _) = floor.refine(&mut Lattice::new(coarse), |x, _| if x < 101 { 0 } else { u64::MAX });
    let levels = levels_of_row(&floor, &edge, 64);
    assert_eq!((levels[100], levels[50], levels[200]), (0, 4, 4));
    fractions(&floor, &edge);

    // A penumbra of 128 pixels: corners 16 pixels apart differ by an eighth, more than the tolerance. They
    // predict the values between them, so cells of 8 pixels are kept.
    let ramp = |x: u32, _: u32| first((x / 2).saturating_sub(32));
    let (penumbra, _) = floor.refine(&mut Lattice::new(coarse), ramp);
    let levels = levels_of_row(&floor, &penumbra, 64);
    assert_eq!((levels[10], levels[100], levels[150], levels[240]), (4, 3, 3, 4));
    // With a tolerance of 0 every pixel that differs from its neighbours is traced.
    let exact = LatticeConfig { error: 0.0, ..coarse };
    let (penumbra, _) = floor.refine(&mut Lattice::new(exact), ramp);
    assert!(levels_of_row(&floor, &penumbra, 64)[66..190].iter().all(|&level| level <= 1));
}

#[test]
fn where_most_pixels_would_be_traced_all_are() {
    let floor = Floor::new(128, 64);
    let config = LatticeConfig { target: 1e-4, ..LatticeConfig::default() };
    // Pixels independent of their neighbours that are fully lit or in umbra: 16 samples suffice.
    let disagreement = |x: u32, y: u32| if ((x * 7919) ^ (y * 104_729)) % 97 < 48 { u64::MAX } else { 0 };
    let (fragments, rays) = floor.refine(&mut Lattice::new(config), disagreement);
    assert_eq!((fragments.cells().len(), fragments.samples().len()), (128 * 64, 128 * 64));
    // The pilot samples: 64 at one corner per cell of 8².
    let pilot = 17 * 9;
    assert_eq!(rays, pilot * 64 + (128 * 64 - pilot) * 16);
    for (pixel, fraction) in fractions(&floor, &fragments).into_iter().enumerate() {
        let seen = disagreement(pixel as u32 % 128, pixel as u32 / 128) != 0;
        assert_eq!(fraction, Some(if seen { 1.0 } else { 0.0 }), "pixel {pixel}");
    }
    // A shadow over a sixth of the image is not dense enough to trace every pixel.
    let (fragments, _) =
        floor.refine(&mut Lattice::new(config), |x, y| if x < 40 { disagreement(x, y) } else { u64::MAX });
    assert!(fragments.cells().iter().any(|cell| cell.level == 3));
}

#[test]
fn fractions_that_are_known_are_those_of_the_masks() {
    let mut floor = Floor::new(128, 64);
    // Some face away from the light and have no fraction.
    floor.gbuffer.normal[..128 * 9].fill(-Vec3::Y);
    let ramp = |x: u32, y: u32| first((x + y % 7).saturating_sub(32));
    let disagreement = |x: u32, y: u32| if ((x * 7919) ^ (y * 104_729)) % 97 < 48 { 0xff } else { u64::MAX };
    for target in [0.0, 1e-3, 1e-6] {
        let config = LatticeConfig { target, ..LatticeConfig::default() };
        for seen in [&ramp as &(dyn Fn(u32, u32) -> u64 + Sync), &disagreement] {
            let mut refiner = Lattice::new(config);
            let (fragments, _, known) = floor.refine_known(&mut refiner, seen);
            let values = |shading, known: &[f32]| {
                let mut values = Values::default();
                let known = RefineOutput { fractions: known, ..RefineOutput::default() };
                irradiance::evaluate(&floor.frame(), &fragments, shading, &known, &mut values);
                (0..values.len()).map(|sample| values.get(0, sample)).collect::<Vec<_>>()
            };
            let known = &known[..];
            assert!(known.iter().any(|fraction| fraction.is_nan()) && known.contains(&1.0));
            assert_eq!(values(Shading::Ratio, known), values(Shading::Ratio, &[]), "{target}");
            // The values are used where they apply, and nowhere else.
            let wrong = [0.25; 40];
            let taken = values(Shading::Ratio, &wrong);
            assert!(taken[..40].iter().all(|&value| value == Some(0.25)));
            assert_eq!(taken[40..], values(Shading::Ratio, &[])[40..]);
            assert_eq!(values(Shading::Sampled, &wrong), values(Shading::Sampled, &[]));
        }
    }
}

#[test]
fn a_thin_shadow_that_one_cell_finds_is_followed() {
    let floor = Floor::new(256, 128);
    // A wire's shadow between the corners of all cells, which one broader spot reveals.
    let wire = |x: u32, y: u32| if y == 37 || (x < 20 && y > 30 && y < 37) { 0 } else { u64::MAX };
    let (fragments, rays) = floor.refine(&mut Lattice::default(), wire);
    assert!(levels_of_row(&floor, &fragments, 37).iter().all(|&level| level == 0));
    assert!(rays < 256 * 128 * 64 / 4, "{rays}");
    let (blind, _) = floor.refine(&mut Lattice::default(), |_, y| if y == 37 { 0 } else { u64::MAX });
    assert!(levels_of_row(&floor, &blind, 37).iter().all(|&level| level == 3), "nothing gives the wire away");
}

#[test]
fn no_crack_between_levels_is_wider_than_the_error() {
    let floor = Floor::new(200, 150);
    // Penumbra rings of many widths.
    let rings = |x: u32, y: u32| {
        let (dx, dy) = (x as f32 - 70.0, y as f32 - 90.0);
        let distance = (dx * dx + dy * dy).sqrt();
        first((32.0 + 40.0 * (900.0 / (distance + 20.0)).sin()).clamp(0.0, 64.0) as u32)
    };
    let config = LatticeConfig::default();
    let (fragments, _) = floor.refine(&mut Lattice::new(config), rings);
    let known = fractions(&floor, &fragments);
    let (mut checked, mut worst) = (0, 0.0f32);
    for cell in fragments.cells().iter().filter(|cell| cell.level > 0) {
        let (x0, y0, ..) = cell.pixels(200, 150);
        let size = 1 << cell.level;
        let (x1, y1) = ((x0 + size).min(199), (y0 + size).min(149));
        let at = |x: u32, y: u32| known[floor.gbuffer.index(x, y)];
        for y in y0 + 1..y1 {
            let down = (y - y0) as f32 / (y1 - y0) as f32;
            for x in [x0, x1] {
                let (Some(top), Some(bottom)) = (at(x, y0), at(x, y1)) else { panic!("a corner is unknown") };
                if let Some(found) = at(x, y) {
                    worst = worst.max((top + (bottom - top) * down - found).abs());
                    checked += 1;
                }
            }
        }
    }
    // Tolerance, plus rounding of the interpolation.
    assert!(checked > 500 && worst <= config.error + 1e-6, "{checked} {worst}");
    assert!(worst > 0.5 * config.error, "nothing to see: {worst}");
}

#[test]
fn cells_split_where_surfaces_may_shade_each_other_and_where_the_light_sets() {
    let levels = |edit: &dyn Fn(&mut GBuffer, usize), seen: u64| {
        let mut floor = Floor::new(64, 32);
        for pixel in (0..floor.gbuffer.pixels()).filter(|pixel| pixel % 64 >= 37) {
            floor.gbuffer.primitive[pixel] = 1;
            edit(&mut floor.gbuffer, pixel);
        }
        let (fragments, _) =
            floor.refine(&mut Lattice::default(), |x, _| if x < 37 { u64::MAX } else { seen });
        let levels = levels_of_row(&floor, &fragments, 9);
        (levels[0], levels[36], levels[37], levels[63])
    };
    // A table far above the floor: each has its own corners, whatever the other's visibility.
    let table = |gbuffer: &mut GBuffer, pixel: usize| gbuffer.position[pixel].y -= 1.0;
    assert_eq!(levels(&table, u64::MAX), (3, 2, 2, 3));
    assert_eq!(levels(&table, 0), (3, 2, 2, 3));
    // A wall with some of the light behind it.
    let wall = |gbuffer: &mut GBuffer, pixel: usize| {
        gbuffer.normal[pixel] = -Vec3::X;
        let position = &mut gbuffer.position[pixel];
        (position.x, position.y) = (36.5 / 64.0 - 1.0, (pixel % 64) as f32 / 64.0 - 36.5 / 64.0);
    };
    assert_eq!(levels(&wall, u64::MAX), (3, 0, 0, 3));
    // A slope that leans away from it: all of the light is in front of both.
    let slope = |gbuffer: &mut GBuffer, pixel: usize| {
        gbuffer.normal[pixel] = Vec3::new(-0.6, 0.8, 0.0);
        let position = &mut gbuffer.position[pixel];
        position.y = (position.x - (36.5 / 64.0 - 1.0)) * 0.6 / 0.8;
    };
    assert_eq!(levels(&slope, u64::MAX), (3, 2, 2, 3));
    // The back of the surface, in the same plane.
    assert_eq!(
        levels(&|gbuffer: &mut GBuffer, pixel: usize| gbuffer.normal[pixel] = -Vec3::Y, u64::MAX),
        (3, 0, 0, 3)
    );
}

/// Edges across the light: a function gives the visible fraction of each pixel, and masks have the noise of jittered samples.
struct Edges<F>(F);

impl<F: Fn(u32, u32) -> f32 + Send> Visibility for Edges<F> {
    fn masks(&mut self, frame: &Frame, batch: &mut MaskBatch) {
        let (words, pattern) = (batch.words(), batch.pattern());
        let columns = u32::from(pattern.columns);
        let (queries, wanted, visible) = batch.slots_mut();
        for (index, query) in queries.iter().enumerate() {
            let fraction = (self.0)(query.pixel % frame.gbuffer.width, query.pixel / frame.gbuffer.width);
            for sample in 0..pattern.len() as u32 {
                let key = halflight_core::hash::fold(halflight_core::hash::mix(query.pixel), sample);
                let (jitter, _) = halflight_core::hash::unit_pair(key);
                let lit = ((sample % columns) as f32 + jitter) / (columns as f32) < fraction;
                let word = index * words + sample as usize / 64;
                visible[word] |= wanted[word] & u64::from(lit) << (sample % 64);
            }
        }
    }
}

/// Visible fractions by pixel, where every pixel has a mask.
fn every_fraction(floor: &Floor, config: LatticeConfig, seen: impl Fn(u32, u32) -> f32 + Send) -> Vec<f32> {
    let config = LatticeConfig { coarsest_level: 0, ..config };
    let (fragments, known) = floor.refine_by(&mut Lattice::new(config), &mut Edges(seen));
    let mut fractions = vec![f32::NAN; floor.gbuffer.pixels()];
    for (sample, fraction) in fragments.samples().iter().zip(known) {
        fractions[sample.pixel as usize] = fraction;
    }
    assert!(fractions.iter().all(|fraction| !fraction.is_nan()));
    fractions
}

#[test]
fn noise_is_smoothed_where_it_explains_the_differences() {
    let floor = Floor::new(160, 64);
    let smoothing = LatticeConfig { target: 1e-4, visible_error: 0.1, ..LatticeConfig::default() };
    let plain = LatticeConfig { visible_error: 0.0, target: 1e-5, ..smoothing };
    // A penumbra of 96 pixels across.
    let ramp = |x: u32, _: u32| (x as f32 - 32.0).clamp(0.0, 96.0) / 96.0;
    let truth = every_fraction(&floor, LatticeConfig { target: 1e-9, ..plain }, ramp);
    let config = LatticeConfig { coarsest_level: 0, ..smoothing };
    let (fragments, known) = floor.refine_by(&mut Lattice::new(config), &mut Edges(ramp));
    // Errors of the masks, and of what the refiner makes of them.
    let (mut raw, mut smoothed) = (0.0, 0.0);
    for (sample, fraction) in fragments.samples().iter().zip(known) {
        let batch = fragments.batch(sample.batch);
        let own = irradiance::fraction(&floor.scene.lights[0], batch, sample.first as usize).unwrap();
        raw += f64::from(own - truth[sample.pixel as usize]).powi(2);
        smoothed += f64::from(fraction - truth[sample.pixel as usize]).powi(2);
    }
    assert!(smoothed < 0.4 * raw, "{smoothed} {raw}");
    // Edges, lines and spots of a pixel stay what they are, and other surfaces have no say: the right half lies a metre lower.
    let mut steps = Floor::new(160, 64);
    for pixel in (0..steps.gbuffer.pixels()).filter(|pixel| pixel % 160 >= 77) {
        steps.gbuffer.primitive[pixel] = 1;
        steps.gbuffer.position[pixel].y -= 1.0;
    }
    type Fraction = fn(u32, u32) -> f32;
    let sharp: [(&Floor, Fraction); 4] = [
        (&floor, |x, _| if x < 77 { 0.0 } else { 1.0 }),
        (&floor, |x, _| if x == 77 { 0.0 } else { 1.0 }),
        (&floor, |x, y| if (x, y) == (77, 30) { 0.0 } else { 1.0 }),
        (&steps, |x, _| if x < 77 { 0.0 } else { 1.0 }),
    ];
    for (floor, seen) in sharp {
        assert_eq!(every_fraction(floor, plain, seen), every_fraction(floor, smoothing, seen));
    }
}

#[test]
fn receivers_with_visible_noise_get_more_samples() {
    let floor = Floor::new(128, 64);
    // Umbra, a fifth of the light, and all of it.
    let seen = |x: u32, _: u32| [0.0, 0.2, 1.0][x as usize / 43];
    let samples_of = |quality: Quality| {
        let config = LatticeConfig { coarsest_level: 0, ..quality.lattice() };
        let (fragments, _) = floor.refine_by(&mut Lattice::new(config), &mut Edges(seen));
        let of = |x: u32| {
            let at = |sample: &&Sample| sample.pixel == 128 * 20 + x;
            let sample = fragments.samples().iter().find(at).unwrap();
            fragments.batch(sample.batch).pattern().len()
        };
        // Some of the penumbra has less noise than the rest.
        let most = (50..80).map(of).max().unwrap();
        // In the umbra beside it, which may only seem to be; far inside the umbra; and in full light.
        [most, of(42), of(20), of(120)]
    };
    let [draft, good, best] = Quality::ALL.map(samples_of);
    assert!(draft[0] <= good[0] && good[0] < best[0], "{draft:?} {good:?} {best:?}");
    for [partly, beside, umbra, lit] in [good, best] {
        assert!(partly > 64 && beside == partly, "{partly} {beside}");
        assert!(umbra < partly && lit < partly, "{umbra} {lit} {partly}");
    }
}
