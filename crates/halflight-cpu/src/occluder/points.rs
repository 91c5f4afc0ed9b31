//! Tests of the samples of a mask one by one, a vector of them at a time: for patterns without rows.

use glam::Vec3;
use halflight_core::light::AreaLight;
use halflight_core::mask::Query;
use halflight_core::pattern::Pattern;

use super::block::Block;
use super::facet::Planes;
use super::over::OverLight;
use super::window::Window;
use super::{NOTHING, NOWHERE, Samples, exact};
use crate::samples::{LANES, positions};
use crate::simd::{Kernel, Lanes, Simd};
use crate::vector::Vector;

/// Light samples in arbitrary positions.
pub(crate) struct Points {
    pattern: Pattern,
    light: AreaLight,
    origin: Vec3,
    window: Window,
    key: u32,
    /// Vectors from the receiver to each sample, 16 samples at a time.
    d: Vec<[[f32; LANES]; 3]>,
    left: Vec<u64>,
    planes: Planes,
}

impl Samples for Points {
    fn new() -> Self {
        Self {
            pattern: NOTHING,
            light: NOWHERE,
            origin: Vec3::ZERO,
            window: Window::NONE,
            key: 0,
            d: Vec::new(),
            left: Vec::new(),
            planes: Planes::new(),
        }
    }

    fn set(&mut self, pattern: Pattern, light: &AreaLight) {
        (self.pattern, self.light) = (pattern, *light);
        self.left.resize(pattern.words(), 0);
        self.d.resize(pattern.words() * 64 / LANES, [[0.0; LANES]; 3]);
    }

    #[inline(always)]
    fn aim<S: Simd>(&mut self, query: &Query, wanted: &[u64]) {
        (self.origin, self.key) = (query.origin, query.key);
        self.window = Window::new(query.origin, &self.light);
        self.left.copy_from_slice(wanted);
        for (group, d) in self.d.iter_mut().enumerate() {
            if (wanted[group * LANES / 64] >> (group * LANES % 64)) as u16 != 0 {
                *d = positions::<S::Wide>(&self.light, self.pattern, query.key, group * LANES);
                for (axis, d) in d.iter_mut().enumerate() {
                    d.iter_mut().for_each(|d| *d -= self.origin[axis]);
                }
            }
        }
    }

    #[inline(always)]
    fn occlude<S: Simd>(&mut self, block: &Block) -> Option<usize> {
        S::call(Occlude { points: self, block })
    }

    #[inline(always)]
    fn any(&self) -> bool {
        self.left.iter().any(|&word| word != 0)
    }

    #[inline(always)]
    fn write(&self, visible: &mut [u64]) {
        visible.copy_from_slice(&self.left);
    }
}

/// Removes the samples that eight triangles hide.
struct Occlude<'a> {
    points: &'a mut Points,
    block: &'a Block,
}

impl Kernel for Occlude<'_> {
    type Output = Option<usize>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Option<usize> {
        let Self { points, block } = self;
        let over = OverLight::<S::Eight>::new(block, points.origin, points.light.frame());
        if over.whole != 0 {
            points.left.fill(0);
            return Some(over.whole.trailing_zeros() as usize);
        }
        if over.may == 0 {
            return None;
        }
        let span = points.window.span::<S::Eight>(block, points.pattern);
        let mut may = over.may & span.some;
        if may == 0 {
            return None;
        }
        let columns = usize::from(points.pattern.columns);
        points.planes.set(&over.facets);
        while may != 0 {
            let lane = may.trailing_zeros() as usize;
            may &= may - 1;
            let facet = points.planes.facet::<S::Wide>(lane);
            let [first, last] = [span.first[1][lane], span.last[1][lane]].map(|row| row as usize);
            let groups = first * columns / LANES..((last + 1) * columns).div_ceil(LANES);
            for group in groups {
                let Some(d) = points.d.get(group) else { break };
                for at in (0..LANES).step_by(S::Wide::WIDTH) {
                    let (word, shift) = (group * LANES / 64, group * LANES % 64 + at);
                    let some = (points.left[word] >> shift) as u32 & S::Wide::ALL;
                    if some == 0 {
                        continue;
                    }
                    let (may, surely) = facet.any_hit(Vector::load(d, at));
                    points.left[word] &= !(u64::from(some & surely) << shift);
                    let mut open = some & may & !surely;
                    while open != 0 {
                        let bit = shift + open.trailing_zeros() as usize;
                        open &= open - 1;
                        let end = points.light.point(points.pattern.position(word * 64 + bit, points.key));
                        if exact::meets(points.origin, end, block.triangle_corners(lane)) {
                            points.left[word] &= !(1 << bit);
                        }
                    }
                }
            }
        }
        None
    }
}
