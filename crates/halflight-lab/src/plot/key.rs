//! Words in charts of points: numbers of the front, notes beside points, and the key.

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::canvas::{Canvas, Drawn, INK};
use super::chart::{Chart, Shape};
use super::layout::{KeyPlace, Layout};
use super::shape::{FRONT, mark};

/// Width of a letter, in parts of its height; on the safe side.
const LETTER: f64 = 0.5;

/// Returns the width of words, units.
fn width(words: &str, size: i32) -> i32 {
    (words.chars().count() as f64 * f64::from(size) * LETTER).ceil() as i32
}

/// Numbers the points of the front and writes notes, each where it covers no word, mark or line. One for which there is no such
/// place beside its point is left out.
pub(super) fn tags<DB: DrawingBackend>(
    canvas: &Canvas<DB>,
    chart: &Chart,
    place: &impl Fn(f64, f64) -> Option<(i32, i32)>,
) -> Drawn<DB> {
    let Layout { plot, tick: size, .. } = chart.layout;
    let numbers = chart.front().into_iter().zip(1..).map(|(point, number)| (point, number.to_string(), INK));
    let notes =
        chart.series.iter().rev().flat_map(|series| series.points.iter().map(move |point| (series, point)));
    let notes = notes.filter_map(|(series, point)| Some((point, point.note.clone()?, series.mark.color())));
    let mut taken = Vec::new();
    for series in &chart.series {
        let placed: Vec<(i32, i32)> =
            series.points.iter().filter_map(|point| place(point.x, point.y)).collect();
        let reach = if series.mark.shape == Shape::Dot { 3 } else { 6 };
        taken.extend(placed.iter().map(|&at| Area::about(at, reach)));
        let joined = placed.windows(2).filter(|_| series.connected);
        taken.extend(joined.flat_map(|ends| along(ends[0], ends[1])).map(|at| Area::about(at, 1)));
    }
    for (point, words, color) in numbers.chain(notes) {
        let Some((x, y)) = place(point.x, point.y) else { continue };
        let free = |at: &Area| at.is_in(plot) && !taken.iter().any(|other| other.meets(at));
        if let Some(at) = beside_point((x, y), width(&words, size), size).find(free) {
            canvas.text(&words, (at.left, at.top), size, color, HPos::Left)?;
            taken.push(at);
        }
    }
    Ok(())
}

/// Returns the places for words beside a point, the preferred first: right above, right below, left below, left above, above
/// and below, near and then somewhat farther off.
fn beside_point((x, y): (i32, i32), width: i32, height: i32) -> impl Iterator<Item = Area> {
    let around = move |gap: i32| {
        let (right, left, middle) = (x + 4 + gap, x - 4 - gap - width, x - width / 2);
        let (above, below) = (y - gap - height, y + gap);
        [
            (right, above),
            (right, below),
            (left, below),
            (left, above),
            (middle, above - 4),
            (middle, below + 4),
        ]
    };
    let corners = [4, 10, 18].into_iter().flat_map(around);
    corners.map(move |(left, top)| Area { left, right: left + width, top, bottom: top + height })
}

/// Returns points of a line, a few units apart.
fn along((x0, y0): (i32, i32), (x1, y1): (i32, i32)) -> impl Iterator<Item = (i32, i32)> {
    let steps = ((x1 - x0).abs().max((y1 - y0).abs()) / 4).max(1);
    (0..=steps).map(move |step| (x0 + (x1 - x0) * step / steps, y0 + (y1 - y0) * step / steps))
}

/// Part of the chart that words or a mark cover.
#[derive(Clone, Copy, Debug)]
struct Area {
    left: i32,
    right: i32,
    top: i32,
    bottom: i32,
}

impl Area {
    /// Returns the square about a point that reaches so far.
    fn about((x, y): (i32, i32), reach: i32) -> Self {
        Self { left: x - reach, right: x + reach, top: y - reach, bottom: y + reach }
    }

    fn meets(&self, other: &Self) -> bool {
        self.left < other.right
            && other.left < self.right
            && self.top < other.bottom
            && other.top < self.bottom
    }

    fn is_in(&self, (left, right, top, bottom): (i32, i32, i32, i32)) -> bool {
        self.left >= left && self.right <= right && self.top >= top && self.bottom <= bottom
    }
}

/// Draws the meanings of marks and numbers.
pub(super) fn key<DB: DrawingBackend>(canvas: &Canvas<DB>, chart: &Chart) -> Drawn<DB> {
    match chart.layout.key {
        KeyPlace::Above => above(canvas, chart),
        KeyPlace::Right => beside(canvas, chart),
    }
}

/// Draws the entries of the key in two columns above the plot.
fn above<DB: DrawingBackend>(canvas: &Canvas<DB>, chart: &Chart) -> Drawn<DB> {
    let Layout { plot: (left, right, _, _), title, label, .. } = chart.layout;
    let entries = chart.key.iter().flat_map(|group| &group.entries);
    for (number, (sample, words)) in (0..).zip(entries) {
        let x = left + number % 2 * (right - left) / 2;
        let y = title + 24 + number / 2 * (label + 6);
        mark(canvas, (x + 8, y + label / 2), *sample)?;
        canvas.text(words, (x + 24, y), label, INK, HPos::Left)?;
    }
    Ok(())
}

/// Draws the key right of the plot, with the names of the front's points.
fn beside<DB: DrawingBackend>(canvas: &Canvas<DB>, chart: &Chart) -> Drawn<DB> {
    let Layout { size, plot: (_, right, top, _), label, tick, .. } = chart.layout;
    let (x, mut y) = (right + 22, top);
    for group in &chart.key {
        canvas.text(&group.title, (x, y), label, INK, HPos::Left)?;
        y += label + 7;
        for (sample, words) in &group.entries {
            mark(canvas, (x + 8, y + label / 2 - 1), *sample)?;
            canvas.text(words, (x + 24, y), label, INK, HPos::Left)?;
            y += label + 4;
        }
        y += 8;
    }
    let front = chart.front();
    if !front.is_empty() {
        canvas.line([(x, y + label / 2), (x + 18, y + label / 2)], FRONT, 2)?;
        canvas.text("Pareto front", (x + 24, y), label, INK, HPos::Left)?;
        y += label + 7;
    }
    let line = tick + 2;
    let room = ((size.1 as i32 - y - 20) / line).max(0) as usize;
    let shown = if front.len() > room { room.saturating_sub(1) } else { front.len() };
    let names = (1..).zip(&front[..shown]).map(|(number, point)| format!("{number}  {}", point.name));
    let more = (shown < front.len()).then(|| format!("and {} more, in the table", front.len() - shown));
    for words in names.chain(more) {
        // Smaller letters rather than names that are cut off.
        let fits = (f64::from(size.0 as i32 - x - 8) / (words.chars().count() as f64 * LETTER)) as i32;
        canvas.text(&words, (x, y), tick.min(fits), INK, HPos::Left)?;
        y += line;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_beside_a_point_keep_clear_of_it() {
        let point = Area::about((100, 100), 6);
        let places: Vec<Area> = beside_point((100, 100), 40, 20).collect();
        assert!(places.iter().all(|place| place.right - place.left == 40 && place.bottom - place.top == 20));
        assert_eq!(places.iter().filter(|place| place.meets(&point)).count(), 0);
        assert!(places[0].is_in((0, 200, 0, 200)) && !places[0].is_in((0, 120, 0, 200)));
    }
}
