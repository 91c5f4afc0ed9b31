//! Indirect light at one receiver: what it receives from lit points, each a patch of the area that the point stands for.
//!
//! The irradiance that a small patch of radiosity B and area A at distance d causes is B · cos θ cos θ′ · x with x = A / (π d²). Summed over the patches of
//! a surface this is the midpoint rule, good from a distance of about a patch on; nearer, x / √(1 + x²) takes the place of x, so that no patch adds more
//! than B. Groups of points count as one patch, but near ones as their points. The sum without occluders is taken over all of them; shadow rays go to some
//! of their points, chosen in proportion to what they add to it by systematic sampling along the points' space-filling curve, and tell which part of
//! the sum arrives.

use glam::Vec3;

use super::lit::Emitter;
use crate::compose::luminance;
use crate::multiversion::multiversion;
use crate::segments::{Occluders, Segments};

/// Distance below which groups are parted into points, squared, in areas of the group.
const NEAR: f32 = 8.0;

/// Rays of the first round, which says how many more are needed.
const PILOT: usize = 64;

/// Factor on the variance of independent rays that systematic sampling along the curve leaves.
const STRATIFIED: f32 = 0.35;

/// Patches that groups of emitters count as, by coordinate, for vectors.
#[derive(Debug, Default)]
pub(crate) struct Patches {
    centre: [Vec<f32>; 3],
    normal: [Vec<f32>; 3],
    area: Vec<f32>,
    /// Largest distance of a member from the centre, metres.
    extent: Vec<f32>,
    /// Luminance of radiosity times area.
    power: Vec<f32>,
    /// Colour of the radiosity, of luminance 1.
    tint: Vec<Vec3>,
}

impl Patches {
    /// Fills the table with a patch for each run of emitters.
    pub(crate) fn fill(&mut self, emitters: &[Emitter], sides: &[u32]) {
        let Self { centre, normal, area, extent, power, tint } = self;
        centre
            .iter_mut()
            .chain(&mut *normal)
            .chain([&mut *area, &mut *extent, &mut *power])
            .for_each(Vec::clear);
        tint.clear();
        for side in sides.windows(2) {
            let own = &emitters[side[0] as usize..side[1] as usize];
            let weight = |emitter: &Emitter| luminance(emitter.radiosity) * emitter.area;
            let all: f32 = own.iter().map(weight).sum();
            let mean = |value: fn(&Emitter) -> Vec3| -> Vec3 {
                own.iter().map(|emitter| value(emitter) * weight(emitter)).sum::<Vec3>() / all
            };
            let (at, facing) =
                (mean(|emitter| emitter.origin), mean(|emitter| emitter.normal).normalize_or_zero());
            for axis in 0..3 {
                centre[axis].push(at[axis]);
                normal[axis].push(facing[axis]);
            }
            extent.push(own.iter().map(|emitter| emitter.origin.distance(at)).fold(0.0, f32::max));
            area.push(own.iter().map(|emitter| emitter.area).sum());
            power.push(all);
            tint.push(own.iter().map(|emitter| emitter.radiosity * emitter.area).sum::<Vec3>() / all);
        }
    }

    /// Memory held, bytes.
    pub(crate) fn bytes(&self) -> usize {
        let columns = self.centre.iter().chain(&self.normal).chain([&self.area, &self.extent, &self.power]);
        columns.map(|column| column.capacity() * 4).sum::<usize>() + self.tint.capacity() * size_of::<Vec3>()
    }
}

/// Emitters and what may hide them.
pub(crate) struct Sources<'a> {
    pub(crate) emitters: &'a [Emitter],
    pub(crate) sides: &'a [u32],
    pub(crate) patches: &'a Patches,
    pub(crate) occluders: Occluders<'a>,
    /// Distance, squared, below which short rays take the place of points; 0 for none.
    pub(crate) reach: f32,
}

/// Part of the light from a distance that points stand for; short rays stand for the rest, where the distance is below the reach. Both squared.
#[inline(always)]
pub(crate) fn far(squared: f32, reach: f32) -> f32 {
    if reach > 0.0 { ((squared / reach - 0.25) * (1.0 / 0.75)).clamp(0.0, 1.0) } else { 1.0 }
}

/// Receiver of indirect light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Receiver {
    pub(crate) origin: Vec3,
    /// Geometric unit normal.
    pub(crate) normal: Vec3,
    /// Shading normal.
    pub(crate) shading: Vec3,
}

/// Part of the light without occluders: of a run of emitters.
#[derive(Clone, Copy, Debug)]
struct Part {
    first: u32,
    end: u32,
    /// Colour, of luminance 1.
    tint: Vec3,
    /// Luminance of the irradiance without occluders.
    value: f32,
}

/// Working memory.
#[derive(Default)]
pub(crate) struct Scratch {
    values: Vec<f32>,
    parts: Vec<Part>,
    /// True if light comes from within the reach.
    near: bool,
    segments: Segments,
    chosen: Vec<Chosen>,
}

/// Emitter that a shadow ray goes to, and what it stands for.
#[derive(Clone, Copy, Debug)]
struct Chosen {
    emitter: u32,
    light: Vec3,
}

/// Light at a receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gathered {
    /// Irradiance, W/m², by channel.
    pub(crate) irradiance: Vec3,
    /// Luminance over the distance that the light arrives from, W/m³: over a small part of the mean distance, the light hardly changes.
    pub(crate) nearness: f32,
    /// True if short rays are due.
    pub(crate) near: bool,
    pub(crate) rays: u32,
}

impl Gathered {
    /// No light.
    pub(crate) const NONE: Self = Self { irradiance: Vec3::ZERO, nearness: 0.0, near: false, rays: 0 };

    /// Harmonic mean of the distances that the light arrives from, metres; infinite where none arrives.
    pub(crate) fn distance(&self) -> f32 {
        if self.nearness > 0.0 { luminance(self.irradiance) / self.nearness } else { f32::INFINITY }
    }
}

/// Light that shadow rays stand for.
#[derive(Clone, Copy, Debug, Default)]
struct Asked {
    all: Vec3,
    /// Part of it that arrives.
    seen: Vec3,
    /// Luminance of that over its distance.
    nearness: f32,
}

/// Rays of a receiver.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    /// Standard deviation to come down to, as a part of the irradiance.
    pub(crate) error: f32,
    /// Most rays.
    pub(crate) most: u32,
}

impl Sources<'_> {
    /// Gathers the light at a receiver. `random` are two numbers in 0 … 1 that place the systematic samples.
    pub(crate) fn gather(
        &self,
        receiver: &Receiver,
        effort: Effort,
        random: [f32; 2],
        scratch: &mut Scratch,
    ) -> Gathered {
        let total = self.part(receiver, scratch);
        if total <= 0.0 {
            return Gathered { near: scratch.near, ..Gathered::NONE };
        }
        let unshadowed: Vec3 = scratch.parts.iter().map(|part| part.tint * part.value).sum();
        let most = (effort.most as usize).max(PILOT);
        let mut asked = Asked::default();
        let mut rays = self.round(receiver, PILOT.min(most), total, random[0], scratch, &mut asked);
        let fraction = luminance(asked.seen) / luminance(asked.all).max(f32::MIN_POSITIVE);
        if fraction < 1.0 && most > PILOT {
            // Part of the light: the fewer rays arrive, the more of them are needed, down to a 32nd of it.
            let wanted =
                STRATIFIED * (1.0 - fraction) / (fraction.max(1.0 / 32.0) * effort.error * effort.error);
            let more = (wanted as usize).saturating_sub(PILOT).next_multiple_of(PILOT).min(most - PILOT);
            if more > 0 {
                let mut again = Asked::default();
                rays += self.round(receiver, more, total, random[1], scratch, &mut again);
                // Each round stands for all of the light.
                let weight = more as f32 / PILOT as f32;
                asked.all += again.all * weight;
                asked.seen += again.seen * weight;
                asked.nearness += again.nearness * weight;
            }
        }
        let part = |channel: usize| {
            if asked.all[channel] > 0.0 { asked.seen[channel] / asked.all[channel] } else { 0.0 }
        };
        let visible = Vec3::new(part(0), part(1), part(2));
        let scale = luminance(unshadowed) / luminance(asked.all).max(f32::MIN_POSITIVE);
        Gathered {
            irradiance: unshadowed * visible,
            nearness: asked.nearness * scale,
            near: scratch.near,
            rays,
        }
    }

    /// Lists what each group adds without occluders, or near ones point by point. Returns the sum.
    fn part(&self, receiver: &Receiver, scratch: &mut Scratch) -> f32 {
        let Scratch { values, parts, near, .. } = scratch;
        values.resize(self.sides.len() - 1, 0.0);
        unoccluded(self.patches, receiver.origin, receiver.normal, receiver.shading, self.reach, values);
        parts.clear();
        *near = false;
        let mut total = 0.0;
        for (side, &value) in values.iter().enumerate() {
            if value == 0.0 {
                continue;
            }
            let (first, end) = (self.sides[side], self.sides[side + 1]);
            if value > 0.0 {
                parts.push(Part { first, end, tint: self.patches.tint[side], value });
                total += value;
                continue;
            }
            for index in first..end {
                let emitter = &self.emitters[index as usize];
                let bright = luminance(emitter.radiosity);
                let part = far(emitter.origin.distance_squared(receiver.origin), self.reach);
                let whole = bright * patch(receiver, emitter);
                *near |= part < 1.0 && whole > 0.0;
                let value = part * whole;
                if value > 0.0 {
                    parts.push(Part {
                        first: index,
                        end: index + 1,
                        tint: emitter.radiosity / bright,
                        value,
                    });
                    total += value;
                }
            }
        }
        total
    }

    /// Traces about `count` rays, chosen by what the parts add to `total`, and adds what they stand for. Returns their number.
    fn round(
        &self,
        receiver: &Receiver,
        count: usize,
        total: f32,
        random: f32,
        scratch: &mut Scratch,
        asked: &mut Asked,
    ) -> u32 {
        let Scratch { parts, segments, chosen, .. } = scratch;
        chosen.clear();
        let step = total / count as f32;
        let (mut next, mut sum) = (random * step, 0.0);
        for part in &*parts {
            let start = sum;
            sum += part.value;
            while next < sum && chosen.len() < count {
                let emitter = self.member(part, (next - start) / part.value);
                next += step;
                // Further rays to the same point would tell nothing new.
                match chosen.last_mut() {
                    Some(last) if last.emitter == emitter => last.light += part.tint * step,
                    _ => chosen.push(Chosen { emitter, light: part.tint * step }),
                }
            }
        }
        for chosen in chosen.chunks(PILOT) {
            for (ray, chosen) in chosen.iter().enumerate() {
                segments.set_end(ray, self.emitters[chosen.emitter as usize].origin);
            }
            let hidden = segments.hidden(self.occluders, receiver.origin, chosen.len());
            for (ray, chosen) in chosen.iter().enumerate() {
                asked.all += chosen.light;
                if hidden >> ray & 1 == 0 {
                    asked.seen += chosen.light;
                    let end = self.emitters[chosen.emitter as usize].origin;
                    asked.nearness +=
                        luminance(chosen.light) / end.distance(receiver.origin).max(f32::MIN_POSITIVE);
                }
            }
        }
        chosen.len() as u32
    }

    /// Emitter of a part at a place, 0 … 1, along the power of its emitters.
    fn member(&self, part: &Part, place: f32) -> u32 {
        if part.end == part.first + 1 {
            return part.first;
        }
        let own = &self.emitters[part.first as usize..part.end as usize];
        let weight = |emitter: &Emitter| luminance(emitter.radiosity) * emitter.area;
        let mut left = place * own.iter().map(weight).sum::<f32>();
        for (index, emitter) in (part.first..).zip(own) {
            left -= weight(emitter);
            if left < 0.0 {
                return index;
            }
        }
        part.end - 1
    }
}

/// Irradiance per radiosity of the patch of a point, without occluders.
fn patch(receiver: &Receiver, emitter: &Emitter) -> f32 {
    let Emitter { origin, normal, area, .. } = *emitter;
    let to = origin - receiver.origin;
    let squared = to.length_squared();
    let (above, facing) = (receiver.shading.dot(to), -normal.dot(to));
    if above <= 0.0 || facing <= 0.0 || receiver.normal.dot(to) <= 0.0 || squared <= 0.0 {
        return 0.0;
    }
    let size = std::f32::consts::PI * squared;
    area * above * facing / (squared * (size * size + area * area).sqrt())
}

multiversion! {
    /// Luminance of what each group adds without occluders; below 0 where it lies near for its size and is to be parted.
    fn unoccluded(table: &Patches, origin: Vec3, normal: Vec3, shading: Vec3, reach: f32, out: &mut [f32]) {
        let count = out.len();
        let [x, y, z] = &table.centre;
        let [nx, ny, nz] = &table.normal;
        let (x, y, z) = (&x[..count], &y[..count], &z[..count]);
        let (nx, ny, nz) = (&nx[..count], &ny[..count], &nz[..count]);
        let (area, extent, power) = (&table.area[..count], &table.extent[..count], &table.power[..count]);
        let reach = reach.sqrt();
        for (index, out) in out.iter_mut().enumerate() {
            let (dx, dy, dz) = (x[index] - origin.x, y[index] - origin.y, z[index] - origin.z);
            let squared = dx * dx + dy * dy + dz * dz;
            let above = shading.x * dx + shading.y * dy + shading.z * dz;
            let over = normal.x * dx + normal.y * dy + normal.z * dz;
            let facing = -(nx[index] * dx + ny[index] * dy + nz[index] * dz);
            let size = std::f32::consts::PI * squared;
            let spread = squared * (size * size + area[index] * area[index]).sqrt();
            let value = power[index] * (above * facing / spread.max(f32::MIN_POSITIVE));
            let sees = (above > 0.0) & (over > 0.0) & (facing > 0.0);
            // Short rays stand for members within the reach.
            let within = if reach > 0.0 { reach + extent[index] } else { 0.0 };
            let near = squared < (NEAR * area[index]).max(within * within);
            *out = if near { -1.0 } else if sees { value } else { 0.0 };
        }
    }
}
