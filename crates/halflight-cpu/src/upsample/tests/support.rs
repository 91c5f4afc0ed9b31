//! Images of planes and random cells for tests of upsamplers.

use halflight_core::fragment::{Fragments, Sample};
use halflight_core::frame::{Frame, Sharing};
use halflight_core::gbuffer::{GBuffer, NO_PRIMITIVE};
use halflight_core::glam::Vec3;
use halflight_core::hash;
use halflight_core::pattern::{Pattern, PatternKind};
use halflight_core::pyramid::Pyramid;
use halflight_core::scene::Scene;
use halflight_core::stages::Upsampler;
use halflight_core::values::{NO_VALUE, Values};

use crate::upsample::{Bilinear, Delaunay, Lattice, RbfAdaptive, RbfFixed, RbfRobust};

/// Pseudo-random numbers from the workspace's hash.
pub(super) struct Random(pub(super) u32);

impl Random {
    pub(super) fn below(&mut self, end: u32) -> u32 {
        self.0 = self.0.wrapping_add(1);
        ((u64::from(hash::mix(self.0)) * u64::from(end)) >> 32) as u32
    }

    /// Number in 0 … 1.
    pub(super) fn unit(&mut self) -> f32 {
        self.below(1 << 24) as f32 / (1 << 24) as f32
    }
}

/// An infinite plane `normal · p = distance`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    pub(super) normal: Vec3,
    pub(super) distance: f32,
}

/// Plane that faces the camera, five metres away.
pub(super) const WALL: Plane = Plane { normal: Vec3::Z, distance: -5.0 };

/// G-buffer seen from the origin along -z, whose pixels lie on the planes that `plane` returns; `None` for
/// the background.
pub(super) fn planes(width: u32, height: u32, plane: impl Fn(u32, u32) -> Option<Plane>) -> GBuffer {
    let mut gbuffer = GBuffer::default();
    gbuffer.reset(width, height);
    let pixel = 2.0 * (Scene::default().camera.fov_y_deg.to_radians() * 0.5).tan() / height as f32;
    for y in 0..height {
        for x in 0..width {
            let index = gbuffer.index(x, y);
            gbuffer.primitive[index] = NO_PRIMITIVE;
            if let Some(Plane { normal, distance }) = plane(x, y) {
                let right = (x as f32 + 0.5 - width as f32 * 0.5) * pixel;
                let up = (height as f32 * 0.5 - y as f32 - 0.5) * pixel;
                let direction = Vec3::new(right, up, -1.0);
                let depth = distance / normal.dot(direction);
                gbuffer.depth[index] = depth;
                gbuffer.position[index] = direction * depth;
                gbuffer.normal[index] = normal;
                // Every plane is a primitive of its own.
                gbuffer.primitive[index] = hash::fold(normal.x.to_bits(), distance.to_bits()) >> 1;
            }
        }
    }
    gbuffer
}

/// Calls `run` with a frame of the default scene.
fn with_frame(gbuffer: &GBuffer, run: impl FnOnce(&Frame)) {
    let (scene, pyramid) = (Scene::default(), Pyramid::default());
    run(&Frame {
        scene: &scene,
        gbuffer,
        pyramid: &pyramid,
        pattern: Pattern { kind: PatternKind::Grid, columns: 8, rows: 8 },
        sharing: Sharing::Fragment,
        index: 0,
        seed: 0,
    });
}

/// Runs an upsampler on an image of NaNs, so that pixels it does not write are found.
pub(super) fn upsample(
    upsampler: &mut dyn Upsampler,
    gbuffer: &GBuffer,
    fragments: &Fragments,
    values: &[f32],
) -> Vec<f32> {
    let mut out = vec![NO_VALUE; gbuffer.pixels()];
    with_frame(gbuffer, |frame| upsampler.upsample(frame, fragments, values, &mut out));
    out
}

/// Runs an upsampler on all channels, on an image of NaNs.
pub(super) fn upsample_channels(
    upsampler: &mut dyn Upsampler,
    gbuffer: &GBuffer,
    fragments: &Fragments,
    values: &Values,
) -> Values {
    let mut out = Values::default();
    out.reset(values.channels(), gbuffer.pixels());
    out.all_mut().fill(NO_VALUE);
    with_frame(gbuffer, |frame| upsampler.upsample_channels(frame, fragments, values, out.all_mut()));
    out
}

/// All upsamplers with their names.
pub(super) fn all() -> [(&'static str, Box<dyn Upsampler>); 6] {
    [
        ("bilinear", Box::new(Bilinear::default())),
        ("rbf-fixed", Box::new(RbfFixed::default())),
        ("rbf-adaptive", Box::new(RbfAdaptive::default())),
        ("rbf-robust", Box::new(RbfRobust::default())),
        ("delaunay", Box::new(Delaunay::default())),
        ("lattice", Box::new(Lattice::default())),
    ]
}

/// Adds a sample at a point of the image whose value holds for the pixel under it.
pub(super) fn sample_at(fragments: &mut Fragments, x: f32, y: f32, level: u8) -> u32 {
    let (width, height) = (fragments.width(), fragments.height());
    let pixel = (y as u32).min(height - 1) * width + (x as u32).min(width - 1);
    fragments.push_sample(Sample { x, y, pixel, level, probes: 0, batch: 0, first: 0 })
}

/// Adds a cell with a sample at the centre of its visible part and, if `additional`, the three of Koa17 §3.4.
pub(super) fn push_cell(fragments: &mut Fragments, level: u8, x: u32, y: u32, additional: bool) {
    let size = 1u32 << level;
    let (left, top) = (x * size, y * size);
    let (right, bottom) = ((left + size).min(fragments.width()), (top + size).min(fragments.height()));
    let centre = ((left + right) as f32 * 0.5, (top + bottom) as f32 * 0.5);
    let mut samples = vec![sample_at(fragments, centre.0, centre.1, level)];
    if additional && level > 0 {
        let half = size / 2;
        for (x, y) in [(left, top), (left + half, top), (left, top + half)] {
            if x < fragments.width() && y < fragments.height() {
                samples.push(sample_at(fragments, x as f32 + 0.5, y as f32 + 0.5, 0));
            }
        }
    }
    fragments.push_cell(level, x, y, &samples);
}

/// Quadtree over the image: `split` returns true if a cell is to be split further.
pub(super) fn quadtree(
    width: u32,
    height: u32,
    top: u8,
    additional: bool,
    split: &mut dyn FnMut(u8, u32, u32) -> bool,
) -> Fragments {
    fn grow(
        fragments: &mut Fragments,
        level: u8,
        x: u32,
        y: u32,
        additional: bool,
        split: &mut dyn FnMut(u8, u32, u32) -> bool,
    ) {
        if x << level >= fragments.width() || y << level >= fragments.height() {
            return;
        }
        if level > 0 && split(level, x, y) {
            for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                grow(fragments, level - 1, 2 * x + dx, 2 * y + dy, additional, split);
            }
        } else {
            push_cell(fragments, level, x, y, additional && level > 2);
        }
    }
    let mut fragments = Fragments::default();
    fragments.reset(width, height, 0);
    for y in 0..height.div_ceil(1 << top) {
        for x in 0..width.div_ceil(1 << top) {
            grow(&mut fragments, top, x, y, additional, split);
        }
    }
    fragments
}

/// Cells of one level with samples at their corners, shared between neighbours, as an external refiner might
/// create them.
pub(super) fn corner_cells(width: u32, height: u32, level: u8) -> Fragments {
    let mut fragments = Fragments::default();
    fragments.reset(width, height, 0);
    let size = 1u32 << level;
    let (columns, rows) = (width.div_ceil(size), height.div_ceil(size));
    let place = |corner: u32, end: u32| (corner * size).min(end - 1) as f32 + 0.5;
    for y in 0..=rows {
        for x in 0..=columns {
            sample_at(&mut fragments, place(x, width), place(y, height), 0);
        }
    }
    for y in 0..rows {
        for x in 0..columns {
            let corner = |dx, dy| (y + dy) * (columns + 1) + x + dx;
            fragments.push_cell(level, x, y, &[corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)]);
        }
    }
    fragments
}

/// Values of all samples by a function of their position.
pub(super) fn values_by(fragments: &Fragments, value: impl Fn(f32, f32) -> f32) -> Vec<f32> {
    fragments.samples().iter().map(|sample| value(sample.x, sample.y)).collect()
}
