//! Sphere lights beside the visibility backends, which answer for the disk that covers the sphere as seen from each receiver
//! ([`Sphere::disk_seen_from`]).
//!
//! - A receiver inside the sphere sees light in every direction: nothing hides any of it, and no ray is traced.
//! - Geometry inside the sphere hides nothing, though a part of it lies between receivers and their disks. Samples that are hidden are therefore
//!   traced again where there is geometry at or in the sphere, up to where the ray enters it. A ray that reaches the disk
//!   needs no second one: it is the longer one.

use halflight_core::frame::Frame;
use halflight_core::light::Sphere;
use halflight_core::mask::{MaskBatch, Query};
use halflight_core::pattern::Pattern;
use rayon::prelude::*;

use crate::bvh::{Bvh, RAYS};
use crate::pool::Pool;
use crate::segments::{Occluders, Segments};

/// Masks of receivers inside a sphere, kept from the backend.
pub(crate) struct Surrounded {
    /// Wanted samples of the whole batch; empty if no receiver is inside.
    wanted: Vec<u64>,
}

/// Clears what receivers inside the sphere want, so that no backend traces it.
pub(crate) fn set_aside(sphere: &Sphere, batch: &mut MaskBatch) -> Surrounded {
    let words = batch.words();
    let inside = |query: &Query| sphere.surrounds(query.origin);
    if words == 0 || !batch.queries().par_iter().with_min_len(1024).any(inside) {
        return Surrounded { wanted: Vec::new() };
    }
    let (queries, wanted, _) = batch.slots_mut();
    let all = wanted.to_vec();
    let slots = queries.par_iter().zip(wanted.par_chunks_mut(words)).with_min_len(1024);
    slots.filter(|(query, _)| inside(query)).for_each(|(_, wanted)| wanted.fill(0));
    Surrounded { wanted: all }
}

/// Completes the answers of a backend: receivers inside the sphere see what they want of it, and hidden samples are traced up to the sphere's
/// surface. `bvh` is the one over the frame's mesh. Returns the number of rays.
pub(crate) fn complete(
    sphere: &Sphere,
    bvh: &Bvh,
    frame: &Frame,
    batch: &mut MaskBatch,
    surrounded: &Surrounded,
) -> u64 {
    let (pattern, words) = (batch.pattern(), batch.words());
    let (low, high) = sphere.padded_bounds(bvh.largest());
    let touched = bvh.has_triangle_in(low, high);
    if words == 0 || surrounded.wanted.is_empty() && !touched {
        return 0;
    }
    let occluders = Occluders { bvh, mesh: &frame.scene.mesh };
    let pool = Pool::default();
    let (queries, wanted, visible) = batch.slots_mut();
    let masks = wanted.par_chunks_mut(words).zip(visible.par_chunks_mut(words));
    let all = queries.par_iter().zip(masks).enumerate().with_min_len(64);
    all.map(|(index, (query, (wanted, visible)))| {
        if !surrounded.wanted.is_empty() && sphere.surrounds(query.origin) {
            wanted.copy_from_slice(&surrounded.wanted[index * words..(index + 1) * words]);
            visible.copy_from_slice(wanted);
            0
        } else if touched && wanted.iter().zip(&*visible).any(|(wanted, visible)| wanted & !visible != 0) {
            pool.lend(Segments::default, |segments| {
                reveal(sphere, occluders, segments, pattern, query, wanted, visible)
            })
        } else {
            0
        }
    })
    .sum()
}

/// Adds hidden samples of a receiver outside the sphere that are visible on the sphere's surface. Returns the number of rays.
fn reveal(
    sphere: &Sphere,
    occluders: Occluders,
    segments: &mut Segments,
    pattern: Pattern,
    query: &Query,
    wanted: &[u64],
    visible: &mut [u64],
) -> u64 {
    let disk = sphere.disk_seen_from(query.origin);
    let mut rays = 0;
    for (word, (wanted, visible)) in wanted.iter().zip(visible).enumerate() {
        let (mut bits, mut count) = ([0u8; RAYS], 0);
        let mut hidden = wanted & !*visible;
        while hidden != 0 {
            let bit = hidden.trailing_zeros();
            hidden &= hidden - 1;
            let uv = pattern.position(word * 64 + bit as usize, query.key) * 2.0 - 1.0;
            let point = disk.centre + disk.axis_u * uv.x + disk.axis_v * uv.y;
            match sphere.before_surface(query.origin, point) {
                Some(end) => {
                    segments.set_end(count, end);
                    bits[count] = bit as u8;
                    count += 1;
                }
                // The receiver touches the sphere.
                None => *visible |= 1 << bit,
            }
        }
        if count > 0 {
            let hidden = segments.hidden(occluders, query.origin, count);
            for (ray, bit) in bits[..count].iter().enumerate() {
                *visible |= u64::from(hidden >> ray & 1 == 0) << bit;
            }
            rays += count as u64;
        }
    }
    rays
}
