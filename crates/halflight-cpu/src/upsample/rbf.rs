//! Single-pass upsampling of the papers by Gaussian radial basis functions, artefacts included.

use halflight_core::fragment::{Cell, Fragments, Sample};
use halflight_core::frame::Frame;
use halflight_core::stages::Upsampler;
use serde::{Deserialize, Serialize};

use super::cells::{Field, Rect, Rows};

/// Most samples of one edge; the rest of a very long edge is left out.
const MAX_EDGE: usize = 192;

/// Determinant below which a matrix counts as singular: single precision leaves no digit of the weights. The
/// matrix has ones on its diagonal, so this is an absolute bound.
const SINGULAR: f32 = 1e-6;

/// Configuration of [`RbfFixed`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RbfFixedConfig {
    /// Variance scaling factor C in `exp(-d²/C)` (Koa16 §3.1.5, Eq. 2b): 2.
    pub variance: f32,
    /// Coarsest level of fragments that are copied (Koa16 §3.1.5): 2.
    pub copied_level: u8,
    /// Largest distance of a chosen sample, in widths of the target's fragment (Koa17 §3.6): 2.
    pub reach: f32,
}

impl Default for RbfFixedConfig {
    fn default() -> Self {
        Self { variance: 2.0, copied_level: 2, reach: 2.0 }
    }
}

/// Configuration of [`RbfAdaptive`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RbfAdaptiveConfig {
    /// Factor before `M̂ + 1` in the variance scaling factor (Koa17 §3.6, Eq. 6): 2.
    pub variance: f32,
    /// Coarsest level of fragments that are copied (Koa17 §3.6): 2.
    pub copied_level: u8,
    /// Largest distance of a chosen sample, in widths of the target's fragment (Koa17 §3.6): 2.
    pub reach: f32,
}

impl Default for RbfAdaptiveConfig {
    fn default() -> Self {
        Self { variance: 2.0, copied_level: 2, reach: 2.0 }
    }
}

/// Upsampling by Gaussian basis functions of one variance (Koa16 §3.1.5).
///
/// A pixel of a fragment above `copied_level` uses the fragment's first sample and, for each of the two edges
/// of its quadrant, the nearest of: the fragment's own additional samples on that edge, the centres of the
/// fragments across it, and their additional samples that lie on it. Distances are divided by the fragment's
/// width. With three samples, the weights solve `Φ w = I`; two have normalised weights (Koa16 Eq. 3); one is
/// copied. Where Φ is singular, a case that the papers leave open, the three have normalised weights as well.
///
/// Constants are not reproduced, values overshoot (negative ones are clamped to 0) and are mixed across
/// edges: see [`RbfRobust`](super::RbfRobust).
#[derive(Debug, Default)]
pub struct RbfFixed {
    config: RbfFixedConfig,
    owners: Vec<u32>,
}

/// Upsampling by Gaussian basis functions whose variance follows the chosen samples' levels (Koa17 §3.6).
///
/// Samples are chosen as by [`RbfFixed`]. `C = 2 (M̂ + 1)` with `M̂` the mean of the samples' levels,
/// weighted by `exp(-d̂² / (2 t_min))`, `t_min` the least width among the samples in pixels. As printed (Eq.
/// 5b), `d` is in pixels, which leaves dark gaps in large fragments; `d` and `d̂` are interpreted as divided
/// by the fragment's width, the interpretation under which the paper's results are possible.
#[derive(Debug, Default)]
pub struct RbfAdaptive {
    config: RbfAdaptiveConfig,
    owners: Vec<u32>,
}

impl RbfFixed {
    /// Creates an upsampler without buffers.
    pub fn new(config: RbfFixedConfig) -> Self {
        Self { config, owners: Vec::new() }
    }
}

impl RbfAdaptive {
    /// Creates an upsampler without buffers.
    pub fn new(config: RbfAdaptiveConfig) -> Self {
        Self { config, owners: Vec::new() }
    }
}

impl Upsampler for RbfFixed {
    fn upsample(&mut self, frame: &Frame, fragments: &Fragments, values: &[f32], out: &mut [f32]) {
        let RbfFixedConfig { variance, copied_level, reach } = self.config;
        let rule = Rule { copied_level, reach, variance: |_: &[Basis]| variance };
        run(frame, fragments, values, out, &mut self.owners, &rule);
    }

    fn bytes(&self) -> usize {
        self.owners.capacity() * 4
    }
}

impl Upsampler for RbfAdaptive {
    fn upsample(&mut self, frame: &Frame, fragments: &Fragments, values: &[f32], out: &mut [f32]) {
        let RbfAdaptiveConfig { variance: factor, copied_level, reach } = self.config;
        let variance = move |chosen: &[Basis]| {
            let narrowest = chosen.iter().map(|basis| basis.level).fold(f32::INFINITY, f32::min).exp2();
            let (mut sum, mut total) = (0.0, 0.0);
            for basis in chosen {
                let alpha = (-basis.distance2 / (2.0 * narrowest)).exp();
                sum += alpha * basis.level;
                total += alpha;
            }
            // Every weight is at least exp(-reach²/2); an unbounded reach could make all of them 0.
            factor * (if total > 0.0 { sum / total } else { 0.0 } + 1.0)
        };
        run(frame, fragments, values, out, &mut self.owners, &Rule { copied_level, reach, variance });
    }

    fn bytes(&self) -> usize {
        self.owners.capacity() * 4
    }
}

/// Rule that differs between the two papers.
struct Rule<V> {
    copied_level: u8,
    reach: f32,
    variance: V,
}

/// Sample that contributes to a pixel.
#[derive(Clone, Copy, Debug, Default)]
struct Basis {
    x: f32,
    y: f32,
    value: f32,
    level: f32,
    /// Squared distance from the pixel, in fragment widths.
    distance2: f32,
    index: u32,
}

/// Samples on one edge of a quadrant.
struct Edge {
    samples: [u32; MAX_EDGE],
    len: usize,
}

impl Default for Edge {
    fn default() -> Self {
        Self { samples: [0; MAX_EDGE], len: 0 }
    }
}

impl Edge {
    fn push(&mut self, index: u32) {
        if self.len < MAX_EDGE {
            self.samples[self.len] = index;
            self.len += 1;
        }
    }

    /// Adds the additional samples of the pixel's own cell that lie on the edge.
    fn push_own(&mut self, field: &Field, cell: &Cell, on_edge: impl Fn(&Sample) -> bool) {
        for &index in field.samples_of(cell).iter().skip(1) {
            if field.sample(index).is_some_and(&on_edge) {
                self.push(index);
            }
        }
    }

    /// Adds the first sample of a cell across the edge, and its additional samples that lie on it.
    fn push_other(&mut self, field: &Field, cell: &Cell, on_edge: impl Fn(&Sample) -> bool) {
        if let Some(&first) = field.samples_of(cell).first() {
            self.push(first);
        }
        self.push_own(field, cell, on_edge);
    }

    fn samples(&self) -> &[u32] {
        &self.samples[..self.len]
    }
}

/// Horizontal and vertical edge of the current quadrant.
#[derive(Default)]
struct Edges {
    horizontal: Edge,
    vertical: Edge,
}

impl Edges {
    /// Collects the samples along the two outer edges of one quadrant of `cell`.
    fn gather(&mut self, field: &Field, cell: &Cell, right: bool, below: bool) {
        let size = 1u32 << cell.level;
        let (left, top) = (u32::from(cell.x) << cell.level, u32::from(cell.y) << cell.level);
        let (x0, y0) = (left + u32::from(right) * size / 2, top + u32::from(below) * size / 2);
        let (x1, y1) = ((x0 + size / 2).min(field.width), (y0 + size / 2).min(field.height));
        let (line_x, line_y) =
            ((left + u32::from(right) * size) as f32, (top + u32::from(below) * size) as f32);
        // A sample within a pixel of the line is on the edge, and one within a pixel beyond its ends still
        // belongs to it.
        let along = |at: f32, from: u32, to: u32| at >= from as f32 - 1.0 && at <= to as f32 + 1.0;
        let on_horizontal = |s: &Sample| (s.y - line_y).abs() <= 1.0 && along(s.x, x0, x1);
        let on_vertical = |s: &Sample| (s.x - line_x).abs() <= 1.0 && along(s.y, y0, y1);
        self.horizontal.len = 0;
        self.vertical.len = 0;
        self.horizontal.push_own(field, cell, on_horizontal);
        self.vertical.push_own(field, cell, on_vertical);
        let across_y =
            if below { top.checked_add(size).filter(|&y| y < field.height) } else { top.checked_sub(1) };
        if let Some(y) = across_y {
            field.walk_row(y, x0, x1, |other| self.horizontal.push_other(field, other, on_horizontal));
        }
        let across_x =
            if right { left.checked_add(size).filter(|&x| x < field.width) } else { left.checked_sub(1) };
        if let Some(x) = across_x {
            field.walk_column(x, y0, y1, |other| self.vertical.push_other(field, other, on_vertical));
        }
    }
}

fn run<V: Fn(&[Basis]) -> f32 + Sync>(
    frame: &Frame,
    fragments: &Fragments,
    values: &[f32],
    out: &mut [f32],
    owners: &mut Vec<u32>,
    rule: &Rule<V>,
) {
    let Some(field) = Field::new(frame.gbuffer, fragments, values, owners, out) else {
        out.fill(0.0);
        return;
    };
    field.for_each_piece(out, |piece, rows, edges: &mut Edges| {
        let first = field.samples_of(piece.cell).first().copied();
        if piece.cell.level <= rule.copied_level {
            let copied = first.and_then(|index| field.value(index)).unwrap_or(0.0);
            each_receiver(frame, &field, piece.rect, rows, |_, _| copied);
            return;
        }
        let half = 1u32 << piece.cell.level >> 1;
        let middle_x = (u32::from(piece.cell.x) << piece.cell.level) + half;
        let middle_y = (u32::from(piece.cell.y) << piece.cell.level) + half;
        let Rect { x0, y0, x1, y1 } = piece.rect;
        for below in [false, true] {
            let (y0, y1) = if below { (y0.max(middle_y), y1) } else { (y0, y1.min(middle_y)) };
            for right in [false, true] {
                let (x0, x1) = if right { (x0.max(middle_x), x1) } else { (x0, x1.min(middle_x)) };
                if x0 < x1 && y0 < y1 {
                    edges.gather(&field, piece.cell, right, below);
                    each_receiver(frame, &field, Rect { x0, y0, x1, y1 }, rows, |x, y| {
                        let target = Target { x, y, width: (2 * half) as f32 };
                        target.value(&field, first, edges, rule)
                    });
                }
            }
        }
    });
}

/// Writes the pixels of a rectangle: 0 for the background, otherwise the value at the pixel's centre.
fn each_receiver(
    frame: &Frame,
    field: &Field,
    rect: Rect,
    rows: &mut Rows,
    mut value: impl FnMut(f32, f32) -> f32,
) {
    for (x, y) in rect.pixels() {
        let pixel = field.pixel(x, y);
        let seen = frame.gbuffer.is_receiver(pixel);
        rows.set(pixel, if seen { value(x as f32 + 0.5, y as f32 + 0.5) } else { 0.0 });
    }
}

/// Pixel to be computed ("target texel") and the width of its fragment, in pixels.
struct Target {
    x: f32,
    y: f32,
    width: f32,
}

impl Target {
    fn value<V: Fn(&[Basis]) -> f32>(
        &self,
        field: &Field,
        first: Option<u32>,
        edges: &Edges,
        rule: &Rule<V>,
    ) -> f32 {
        let mut chosen = [Basis::default(); 3];
        let mut count = 0;
        let centre = first.and_then(|index| self.basis(field, index));
        for edge in [None, Some(&edges.horizontal), Some(&edges.vertical)] {
            let next = match edge {
                None => centre,
                Some(edge) => self.nearest(field, edge.samples(), rule.reach, &chosen[..count]),
            };
            if let Some(basis) = next {
                chosen[count] = basis;
                count += 1;
            }
        }
        let chosen = &chosen[..count];
        let variance = (rule.variance)(chosen);
        if let &[a, b, c] = chosen
            && let Some(value) = self.solve(a, b, c, variance)
        {
            return value;
        }
        normalised(chosen, variance)
    }

    /// Sample relative to the pixel; an undefined value counts as 0.
    fn basis(&self, field: &Field, index: u32) -> Option<Basis> {
        let sample = field.sample(index)?;
        Some(Basis {
            x: sample.x,
            y: sample.y,
            value: field.value(index).unwrap_or(0.0),
            level: f32::from(sample.level),
            distance2: self.distance2(self.x - sample.x, self.y - sample.y),
            index,
        })
    }

    fn distance2(&self, dx: f32, dy: f32) -> f32 {
        (dx * dx + dy * dy) / (self.width * self.width)
    }

    /// Nearest of the samples within reach that has not been chosen yet.
    fn nearest(&self, field: &Field, samples: &[u32], reach: f32, chosen: &[Basis]) -> Option<Basis> {
        let mut best: Option<Basis> = None;
        for &index in samples {
            if let Some(basis) = self.basis(field, index)
                && basis.distance2 < best.map_or(reach * reach, |b| b.distance2)
                && chosen.iter().all(|other| other.index != index)
            {
                best = Some(basis);
            }
        }
        best
    }

    /// Koa17 Eq. 4 and 5a, by Cramer's rule on the symmetric matrix; `None` where it is singular.
    fn solve(&self, a: Basis, b: Basis, c: Basis, variance: f32) -> Option<f32> {
        let phi = |p: &Basis, q: &Basis| (-self.distance2(p.x - q.x, p.y - q.y) / variance).exp();
        let (ab, ac, bc) = (phi(&a, &b), phi(&a, &c), phi(&b, &c));
        let determinant = 1.0 + 2.0 * ab * ac * bc - ab * ab - ac * ac - bc * bc;
        if determinant.is_nan() || determinant <= SINGULAR {
            return None;
        }
        // Rows of the adjugate.
        let wa = (1.0 - bc * bc) * a.value + (ac * bc - ab) * b.value + (ab * bc - ac) * c.value;
        let wb = (ac * bc - ab) * a.value + (1.0 - ac * ac) * b.value + (ab * ac - bc) * c.value;
        let wc = (ab * bc - ac) * a.value + (ab * ac - bc) * b.value + (1.0 - ab * ab) * c.value;
        let at = |basis: &Basis| (-basis.distance2 / variance).exp();
        let value = (wa * at(&a) + wb * at(&b) + wc * at(&c)) / determinant;
        // Between samples the Gaussians can be negative, which neither irradiance nor a visible fraction is.
        value.is_finite().then_some(value.max(0.0))
    }
}

/// Koa16 Eq. 3, Koa17 Eq. 9; 0 without samples.
fn normalised(chosen: &[Basis], variance: f32) -> f32 {
    let (mut sum, mut total) = (0.0, 0.0);
    for basis in chosen {
        let weight = (-basis.distance2 / variance).exp();
        sum += weight * basis.value;
        total += weight;
    }
    if total > 0.0 { sum / total } else { 0.0 }
}
