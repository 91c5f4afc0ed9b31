//! Tests of whole rows of a light's sample grid at once (Wang17 §3.3).
//!
//! A triangle hides from a receiver the light samples on the inner side of four planes: those through the
//! receiver and each edge, and the triangle's own. A row of a regular grid crosses each plane once, so the
//! hidden samples are one run of columns, whatever the number of columns; rows are the lanes of a vector.
//! Every crossing has a bound on its rounding error; samples within it are decided exactly.

use std::ops::RangeInclusive;

use glam::Vec3;
use halflight_core::hash;
use halflight_core::light::AreaLight;
use halflight_core::mask::Query;
use halflight_core::pattern::{Pattern, PatternKind};

use super::block::Block;
use super::over::OverLight;
use super::window::Window;
use super::{NOTHING, NOWHERE, Samples, exact};
use crate::simd::{Kernel, Lanes, Simd};

/// Most rows and most columns of a pattern.
const SIDE: usize = 64;

/// Capacity in rows: a vector that starts at the last row fits.
const ROWS: usize = SIDE + 16;

/// Distance in columns within which a crossing is never trusted: more than the error of truncating it to an
/// integer.
const SLACK: f32 = 1.0 / 1024.0;

/// Visible samples of one receiver, row by row, in a regular grid or one with shifted rows.
pub(crate) struct Rows {
    pattern: Pattern,
    light: AreaLight,
    origin: Vec3,
    window: Window,
    /// Key of the receiver's pattern; `None` before the first receiver.
    key: Option<u32>,
    /// Position of each row along the light's second edge, 0 … 1.
    v: [f32; ROWS],
    /// Offset of each row's samples from the left ends of their columns, in columns.
    shift: [f32; ROWS],
    /// Mask of the wanted samples that no triangle has hidden yet: columns 0 … 31 and 32 … 63 of each row.
    left: [[u32; ROWS]; 2],
    /// Four planes of eight triangles.
    planes: [Plane; 4],
}

/// Plane of each of eight triangles, as the column at which rows cross it: `start + slope · v`, with the
/// error bound `slack`.
#[derive(Clone, Copy)]
struct Plane {
    start: [f32; 8],
    slope: [f32; 8],
    slack: [f32; 8],
    /// Triangles that lie to the right of the crossing.
    right: u32,
    /// Triangles that have the whole light on their side of the plane.
    whole: u32,
}

impl Plane {
    const EMPTY: Self = Self { start: [0.0; 8], slope: [0.0; 8], slack: [0.0; 8], right: 0, whole: 0 };

    /// Sets the plane from the function `a + bu · u + bv · v` of the position on the light, positive inside,
    /// with an error of at most `error`.
    #[inline(always)]
    fn set<L: Lanes>(&mut self, columns: f32, a: L, bu: L, bv: L, error: L) {
        let zero = L::splat(0.0);
        let negative = bu.lt(zero);
        let step = bu.abs().mul(L::splat(1.0 / columns));
        // Rows that run parallel to a plane cross it nowhere or everywhere. The plane is tilted by as much as
        // rounding might have tilted it, and the error grows by the resulting displacement at the last
        // column.
        let steep = step.max(error.mul(L::splat(1.0 / columns)));
        let error = error.add(steep.sub(step).mul(L::splat(columns)));
        let inverse = L::splat(1.0).div(steep);
        let turned = L::splat(-1.0).select(negative, L::splat(1.0)).mul(inverse);
        a.mul(turned).store(&mut self.start);
        bv.mul(turned).store(&mut self.slope);
        error.mul(inverse).add(L::splat(SLACK)).store(&mut self.slack);
        self.right = !negative;
    }
}

impl Rows {
    /// True if a pattern has straight rows, and few enough rows and columns.
    pub(crate) fn fit(pattern: Pattern) -> bool {
        pattern.kind != PatternKind::Jittered
            && usize::from(pattern.columns) <= SIDE
            && usize::from(pattern.rows) <= SIDE
    }

    fn shift_rows(&mut self, key: u32) {
        let scale = 1.0 / f32::from(self.pattern.rows);
        for row in 0..usize::from(self.pattern.rows) {
            let (du, dv) = hash::unit_pair(hash::sample_bits(key, row as u32));
            self.shift[row] = du;
            self.v[row] = (row as f32 + dv) * scale;
        }
    }

    /// Removes the samples that one triangle hides in some rows, `L::WIDTH` rows at a time.
    #[inline(always)]
    fn take<L: Lanes>(&mut self, block: &Block, lane: usize, rows: RangeInclusive<usize>) {
        let columns = f32::from(self.pattern.columns);
        let bit = 1u32 << lane;
        let (minus, last, one) = (L::splat(-1.0), L::splat(columns - 1.0), L::splat(1.0));
        let (zero, end, ceiling) = (L::splat(0.0), L::splat(columns), L::splat(128.0));
        for row in rows.step_by(L::WIDTH) {
            let v = L::load(&self.v[row..]);
            let far = L::splat(1e9);
            let (mut low_sure, mut low_may) = (L::splat(-1e9), L::splat(-1e9));
            let (mut high_sure, mut high_may) = (far, far);
            for plane in &self.planes {
                if plane.whole & bit != 0 {
                    continue;
                }
                let at = v.mul(L::splat(plane.slope[lane]));
                let (start, slack) = (plane.start[lane], plane.slack[lane]);
                let (before, behind) = (at.add(L::splat(start - slack)), at.add(L::splat(start + slack)));
                if plane.right & bit != 0 {
                    (low_sure, low_may) = (low_sure.max(behind), low_may.max(before));
                } else {
                    (high_sure, high_may) = (high_sure.min(before), high_may.min(behind));
                }
            }
            let shift = L::load(&self.shift[row..]);
            let first_sure = low_sure.sub(shift).max(minus).min(end).add(one).truncate();
            let last_sure = ceiling.sub(ceiling.sub(high_sure.sub(shift).max(zero).min(end)).truncate());
            let first_may = ceiling.sub(ceiling.sub(low_may.sub(shift).max(zero).min(end)).truncate());
            let last_may = high_may.sub(shift).max(minus).min(last).add(one).truncate();
            for half in 0..self.pattern.columns.div_ceil(32) {
                let skip = L::splat(f32::from(32 * half));
                let (mut sure, mut may) = ([0u32; 16], [0u32; 16]);
                L::run_of_bits(first_sure.sub(skip).max(zero), last_sure.sub(skip).max(zero), &mut sure);
                L::run_of_bits(first_may.sub(skip).max(zero), last_may.sub(skip).max(zero), &mut may);
                let left = &mut self.left[usize::from(half)][row..row + L::WIDTH];
                let mut open = 0;
                for (lane, left) in left.iter_mut().enumerate() {
                    *left &= !sure[lane];
                    open |= *left & may[lane];
                }
                if open != 0 {
                    self.decide(block, lane, usize::from(half), row, &may[..L::WIDTH]);
                }
            }
        }
    }

    /// Decides single samples in exact arithmetic.
    #[cold]
    #[inline(never)]
    fn decide(&mut self, block: &Block, lane: usize, half: usize, row: usize, may: &[u32]) {
        let corners = block.triangle_corners(lane);
        let columns = usize::from(self.pattern.columns);
        for (at, &may) in (row..).zip(may) {
            let mut open = self.left[half][at] & may;
            while open != 0 {
                let column = open.trailing_zeros() as usize;
                open &= open - 1;
                let index = at * columns + half * 32 + column;
                let end = self.light.point(self.pattern.position(index, self.key.unwrap_or_default()));
                if exact::meets(self.origin, end, corners) {
                    self.left[half][at] &= !(1 << column);
                }
            }
        }
    }
}

impl Samples for Rows {
    fn new() -> Self {
        Self {
            pattern: NOTHING,
            light: NOWHERE,
            origin: Vec3::ZERO,
            window: Window::NONE,
            key: None,
            v: [0.0; ROWS],
            shift: [0.5; ROWS],
            left: [[0; ROWS]; 2],
            planes: [Plane::EMPTY; 4],
        }
    }

    fn set(&mut self, pattern: Pattern, light: &AreaLight) {
        (self.pattern, self.light, self.key) = (pattern, *light, None);
        self.left = [[0; ROWS]; 2];
        self.shift = [0.5; ROWS];
        let scale = 1.0 / f32::from(pattern.rows);
        for (row, v) in self.v.iter_mut().enumerate() {
            *v = (row as f32 + 0.5) * scale;
        }
    }

    #[inline(always)]
    fn aim<S: Simd>(&mut self, query: &Query, wanted: &[u64]) {
        if self.pattern.kind == PatternKind::ShiftedRows && self.key != Some(query.key) {
            self.shift_rows(query.key);
        }
        (self.origin, self.key) = (query.origin, Some(query.key));
        self.window = Window::new(query.origin, &self.light);
        let (columns, rows) = (usize::from(self.pattern.columns), usize::from(self.pattern.rows));
        let mask = if columns == 64 { u64::MAX } else { (1 << columns) - 1 };
        for row in 0..rows {
            let (word, bit) = (row * columns / 64, row * columns % 64);
            let mut bits = wanted[word] >> bit;
            if bit + columns > 64 {
                bits |= wanted[word + 1] << (64 - bit);
            }
            let bits = bits & mask;
            (self.left[0][row], self.left[1][row]) = (bits as u32, (bits >> 32) as u32);
        }
    }

    #[inline(always)]
    fn occlude<S: Simd>(&mut self, block: &Block) -> Option<usize> {
        S::call(Occlude { rows: self, block })
    }

    #[inline(always)]
    fn any(&self) -> bool {
        let mut all = 0;
        for row in 0..usize::from(self.pattern.rows) {
            all |= self.left[0][row] | self.left[1][row];
        }
        all != 0
    }

    #[inline(always)]
    fn write(&self, visible: &mut [u64]) {
        let (columns, rows) = (usize::from(self.pattern.columns), usize::from(self.pattern.rows));
        visible.fill(0);
        for row in 0..rows {
            let bits = u64::from(self.left[0][row]) | u64::from(self.left[1][row]) << 32;
            let (word, bit) = (row * columns / 64, row * columns % 64);
            visible[word] |= bits << bit;
            if bit + columns > 64 {
                visible[word + 1] |= bits >> (64 - bit);
            }
        }
    }
}

/// Removes the samples that eight triangles hide.
struct Occlude<'a> {
    rows: &'a mut Rows,
    block: &'a Block,
}

impl Kernel for Occlude<'_> {
    type Output = Option<usize>;

    #[inline(always)]
    fn run<S: Simd>(self) -> Option<usize> {
        let Self { rows, block } = self;
        let over = OverLight::<S::Eight>::new(block, rows.origin, rows.light.frame());
        if over.whole != 0 {
            rows.left = [[0; ROWS]; 2];
            return Some(over.whole.trailing_zeros() as usize);
        }
        if over.may == 0 {
            return None;
        }
        let span = rows.window.span::<S::Eight>(block, rows.pattern);
        let mut may = over.may & span.some;
        if may == 0 {
            return None;
        }
        let columns = f32::from(rows.pattern.columns);
        for (index, plane) in rows.planes.iter_mut().enumerate() {
            plane.set(columns, over.a[index], over.bu[index], over.bv[index], over.error[index]);
            plane.whole = over.inside[index];
        }
        while may != 0 {
            let lane = may.trailing_zeros() as usize;
            may &= may - 1;
            if over.unsure >> lane & 1 != 0 {
                for half in 0..2 {
                    rows.decide(block, lane, half, 0, &[u32::MAX; ROWS]);
                }
            } else {
                let [first, last] = [span.first[1][lane], span.last[1][lane]].map(|row| row as usize);
                S::call(Take { rows: &mut *rows, block, lane, first, last });
            }
        }
        None
    }
}

/// Removes the samples that one triangle hides.
struct Take<'a> {
    rows: &'a mut Rows,
    block: &'a Block,
    lane: usize,
    first: usize,
    last: usize,
}

impl Kernel for Take<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { rows, block, lane, first, last } = self;
        if last < first + 8 {
            rows.take::<S::Eight>(block, lane, first..=last);
        } else {
            rows.take::<S::Wide>(block, lane, first..=last);
        }
    }
}
