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

/// Rays of a packet.
const PACKET: usize = 64;

/// Packets that are traced by one thread.
const PACKETS: usize = 16;

/// Fills `out` with the nearest surfaces at points of an image of this size: a row for each of `pixels`, with a column for each of
/// `offsets` (pixels, to the right and down) from its centre. Hits are decided as [`trace`](super::trace) decides them.
///
/// Pixels that follow each other should be neighbours: their rays travel together.
pub(crate) fn trace_sub_samples(
    bvh: &Bvh,
    scene: &Scene,
    (width, height): (u32, u32),
    pixels: &[u32],
    offsets: &[Vec2],
    out: &mut GBuffer,
) {
    out.reset(offsets.len() as u32, pixels.len() as u32);
    let (isa, view) = (Isa::best(), View::new(&scene.camera, width, height));
    let together = (PACKET / offsets.len().max(1)).max(1);
    let task = together * PACKETS;
    if out.pixels() == 0 {
        return;
    }
    let tasks = pixels.par_chunks(task).zip(Layers::parts(out, &scene.mesh, task * offsets.len()));
    tasks.with_max_len(1).for_each(|(pixels, layers)| {
        isa.run(Task { bvh, mesh: &scene.mesh, width, view: &view, pixels, offsets, together, layers });
    });
}

/// Packets of the sub-samples of some pixels.
struct Task<'a> {
    bvh: &'a Bvh,
    mesh: &'a Mesh,
    width: u32,
    view: &'a View,
    pixels: &'a [u32],
    offsets: &'a [Vec2],
    /// Pixels of a packet.
    together: usize,
    layers: Layers<'a>,
}

impl Kernel for Task<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self) {
        let Self { width, view, offsets, together, .. } = self;
        let mut rays = Rays::new(self.bvh, self.mesh, view.eye);
        for (index, pixels) in self.pixels.chunks(together).enumerate() {
            let direction = |ray: usize| {
                let (pixel, offset) = (pixels[ray / offsets.len()], offsets[ray % offsets.len()].as_dvec2());
                let (x, y) = (f64::from(pixel % width) + 0.5, f64::from(pixel / width) + 0.5);
                view.through(x + offset.x, y + offset.y)
            };
            let first = index * together * offsets.len();
            rays.trace::<S>(pixels.len() * offsets.len(), direction, |ray| first + ray, &mut self.layers);
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
            let mut found = GBuffer::default();
            trace_sub_samples(&bvh, &scene, (width, height), &pixels, offsets, &mut found);
            assert_eq!((found.width, found.height as usize), (count, pixels.len()));
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
