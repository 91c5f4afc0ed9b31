//! Sub-samples of pixels, found by packets of primary rays.

use glam::Vec2;
use halflight_core::camera::View;
use halflight_core::gbuffer::GBuffer;
use halflight_core::scene::{Mesh, Scene};
use rayon::prelude::*;

use super::rays::Rays;
use super::surface::Layers;
use crate::bvh::Bvh;
use crate::simd::{Isa, Kernel, Simd};

/// Most rays of a packet, which are those of one tile: what a packet costs depends on what lies before and behind an edge more than on the
/// number of rays.
const PACKET: usize = 256;

/// Pixels along the side of a tile.
const TILE: u32 = 8;

/// Sub-samples that are traced by one thread.
const TASK: usize = 1024;

/// Sub-sample of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SubSample {
    pub(crate) pixel: u32,
    /// Number of its offset.
    pub(crate) offset: u8,
}

/// Fills `out` with the nearest surfaces at `samples` of an image of this size, one entry each; `offsets` are those from the pixels' centres, in
/// pixels to the right and down. Hits are decided as [`trace`](super::trace) decides them.
///
/// Sub-samples that follow each other should be neighbours: their rays travel together.
pub(crate) fn trace_sub_samples(
    bvh: &Bvh,
    scene: &Scene,
    (width, height): (u32, u32),
    offsets: &[Vec2],
    samples: &[SubSample],
    out: &mut GBuffer,
) {
    out.reset(samples.len() as u32, 1);
    let (isa, view) = (Isa::best(), View::new(&scene.camera, width, height));
    let tasks = samples.par_chunks(TASK).zip(Layers::parts(out, &scene.mesh, TASK));
    tasks.with_max_len(1).for_each(|(samples, layers)| {
        isa.run(Task { bvh, mesh: &scene.mesh, width, view: &view, offsets, samples, layers });
    });
}

/// Packets of some sub-samples.
struct Task<'a> {
    bvh: &'a Bvh,
    mesh: &'a Mesh,
    width: u32,
    view: &'a View,
    offsets: &'a [Vec2],
    samples: &'a [SubSample],
    layers: Layers<'a>,
}

impl Kernel for Task<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self) {
        let Self { width, view, offsets, samples, .. } = self;
        let mut rays = Rays::<PACKET>::new(self.bvh, self.mesh, view.eye);
        let tile = |sample: &SubSample| (sample.pixel / width / TILE, sample.pixel % width / TILE);
        let mut first = 0;
        for samples in samples.chunk_by(|a, b| tile(a) == tile(b)).flat_map(|samples| samples.chunks(PACKET))
        {
            let direction = |ray: usize| {
                let SubSample { pixel, offset } = samples[ray];
                let offset = offsets[usize::from(offset)].as_dvec2();
                let (x, y) = (f64::from(pixel % width) + 0.5, f64::from(pixel / width) + 0.5);
                view.through(x + offset.x, y + offset.y)
            };
            rays.trace::<S>(samples.len(), direction, |ray| first + ray, &mut self.layers);
            first += samples.len();
        }
    }
}

#[cfg(test)]
mod tests {
    use halflight_core::subpixel;

    use super::*;
    use crate::bvh::tests::meshes::{hall, lamp, scene};
    use crate::gbuffer::trace;
    use glam::Vec3;

    #[test]
    fn sub_samples_are_the_pixels_of_shifted_cameras() {
        let mut scene = scene(&hall(), lamp(Vec3::new(4.0, 3.8, 8.0), 1.5));
        scene.camera.eye = Vec3::new(3.0, 1.7, 15.0);
        scene.camera.target = Vec3::new(4.5, 1.5, 4.0);
        let bvh = Bvh::build(&scene.mesh).unwrap();
        let (width, height) = (37, 23);
        let pixels: Vec<u32> = (0..width * height).filter(|pixel| pixel % 3 != 1).collect();
        for count in subpixel::COUNTS {
            let offsets = subpixel::offsets(count).unwrap();
            let of = |&pixel: &u32| (0..count as u8).map(move |offset| SubSample { pixel, offset });
            let samples: Vec<SubSample> = pixels.iter().flat_map(of).collect();
            let mut found = GBuffer::default();
            trace_sub_samples(&bvh, &scene, (width, height), offsets, &samples, &mut found);
            assert_eq!(found.pixels(), samples.len());
            for (column, &offset) in offsets.iter().enumerate() {
                let mut shifted = scene.clone();
                shifted.camera = subpixel::shifted(&scene.camera, offset, width, height);
                let mut expected = GBuffer::default();
                trace(&bvh, &shifted, width, height, &mut expected);
                let mut others = 0;
                for (row, &pixel) in pixels.iter().enumerate() {
                    let (at, pixel) = (row * offsets.len() + column, pixel as usize);
                    if found.primitive[at] != expected.primitive[pixel] {
                        others += 1;
                        continue;
                    }
                    let apart = found.position[at].distance(expected.position[pixel]);
                    assert!(apart < 1e-3 && found.normal[at] == expected.normal[pixel], "{pixel}: {apart}");
                }
                // Shifts are rounded to single precision.
                assert!(others * 500 <= pixels.len() && (count > 1 || others == 0), "{others}");
            }
        }
    }
}
