//! Drawing of charts of points.

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::canvas::{Canvas, Drawn, INK, NOISE, SIZE};
use super::chart::{Chart, Mark, Scale, Shape};
use super::drawing::Drawing;

/// Left, right, top and bottom of the plot; the key is to its right.
const PLOT: (i32, i32, i32, i32) = (86, 960, 64, 690);
/// Distance of the outermost points from the frame, in parts of the plot.
const MARGIN: f64 = 0.05;
/// Least extent of an axis: a factor of two and a half, or 0.4 units.
const NARROWEST: f64 = 0.4;
const GRID: RGBColor = RGBColor(228, 228, 228);
const FRONT: RGBColor = RGBColor(120, 120, 120);

/// Returns a quantity on a scale.
fn apply(scale: Scale, value: f64) -> f64 {
    match scale {
        Scale::Linear => value,
        Scale::Log => value.log10(),
    }
}

/// Axis: maps a quantity to pixels.
struct Axis {
    scale: Scale,
    low: f64,
    high: f64,
    from: i32,
    to: i32,
}

impl Axis {
    fn new(scale: Scale, values: impl Iterator<Item = f64>, from: i32, to: i32) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.map(|value| apply(scale, value)).filter(|value| value.is_finite()) {
            (low, high) = (low.min(value), high.max(value));
        }
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        // Wide enough for two ticks at least.
        let margin = ((high - low) * MARGIN).max(0.5 * (NARROWEST - (high - low)));
        Self { scale, low: low - margin, high: high + margin, from, to }
    }

    fn pixel(&self, value: f64) -> Option<i32> {
        let part = (apply(self.scale, value) - self.low) / (self.high - self.low);
        (0.0..=1.0)
            .contains(&part)
            .then(|| self.from + (part * f64::from(self.to - self.from)).round() as i32)
    }

    /// Returns values to label: powers of ten, with round numbers between them where there are few.
    fn ticks(&self) -> Vec<f64> {
        match self.scale {
            Scale::Log => {
                const FACTORS: [&[f64]; 3] =
                    [&[1.0], &[1.0, 2.0, 5.0], &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0]];
                let decades = self.low.floor() as i32..=self.high.ceil() as i32;
                let ticks = |factors: &[f64]| -> Vec<f64> {
                    let decades = decades.clone();
                    let ticks =
                        decades.flat_map(|decade| factors.iter().map(move |f| f * 10f64.powi(decade)));
                    ticks.filter(|&tick| self.pixel(tick).is_some()).collect()
                };
                let fine = ticks(FACTORS[2]);
                FACTORS.into_iter().map(ticks).find(|ticks| ticks.len() >= 4).unwrap_or(fine)
            }
            Scale::Linear => {
                let rough = (self.high - self.low) / 6.0;
                let decade = 10f64.powf(rough.log10().floor());
                let step =
                    [1.0, 2.0, 5.0, 10.0].iter().map(|factor| factor * decade).find(|&step| step >= rough);
                let step = step.unwrap_or(rough);
                let first = (self.low / step).ceil() as i64;
                (first..).map(|index| index as f64 * step).take_while(|&tick| tick <= self.high).collect()
            }
        }
    }
}

/// Returns a number for a tick: plain, in thousands or millions, or as 2e-4.
fn short(value: f64) -> String {
    let rounded = |value: f64| ((value * 1e4).round() / 1e4).to_string();
    match value.abs() {
        size if size >= 1e6 => format!("{} M", rounded(value / 1e6)),
        size if size >= 1e4 => format!("{} k", rounded(value / 1e3)),
        size if size >= 1e-3 || size == 0.0 => rounded(value),
        _ => format!("{value:.0e}"),
    }
}

impl Drawing for Chart {
    fn title(&self) -> &str {
        &self.title
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn<DB> {
        draw(canvas, self)
    }
}

/// Draws a chart.
fn draw<DB: DrawingBackend>(canvas: &Canvas<DB>, chart: &Chart) -> Drawn<DB> {
    canvas.area.fill(&WHITE)?;
    let (left, right, top, bottom) = PLOT;
    let points = || chart.series.iter().flat_map(|series| &series.points);
    let x_axis = Axis::new(chart.x_scale, points().map(|point| point.x), left, right);
    let noise = chart.noise.into_iter();
    let y_axis = Axis::new(Scale::Log, points().map(|point| point.y).chain(noise), bottom, top);

    canvas.text(&chart.title, (left, 14), 22, INK, HPos::Left)?;
    canvas.text(&chart.y_label, (left - 60, 40), 15, INK, HPos::Left)?;
    canvas.text(&chart.x_label, (right, bottom + 32), 15, INK, HPos::Right)?;
    for tick in x_axis.ticks() {
        if let Some(x) = x_axis.pixel(tick) {
            canvas.line([(x, top), (x, bottom)], GRID, 1)?;
            canvas.text(&short(tick), (x, bottom + 8), 14, INK, HPos::Center)?;
        }
    }
    for tick in y_axis.ticks() {
        if let Some(y) = y_axis.pixel(tick) {
            canvas.line([(left, y), (right, y)], GRID, 1)?;
            canvas.text(&short(tick), (left - 8, y - 7), 14, INK, HPos::Right)?;
        }
    }
    canvas.line([(left, top), (right, top), (right, bottom), (left, bottom), (left, top)], INK, 1)?;

    if let Some(noise) = chart.noise
        && let Some(y) = y_axis.pixel(noise)
    {
        for x in (left..right).step_by(10) {
            canvas.line([(x, y), ((x + 5).min(right), y)], NOISE, 1)?;
        }
        let words = format!("noise of the reference, {noise:.1e}");
        canvas.text(&words, (left + 8, y - 18), 14, NOISE, HPos::Left)?;
    }
    let place = |x: f64, y: f64| Some((x_axis.pixel(x)?, y_axis.pixel(y)?));
    let front: Vec<(i32, i32)> = chart.front().iter().filter_map(|point| place(point.x, point.y)).collect();
    if let (Some(&first), Some(&last)) = (front.first(), front.last()) {
        // A staircase: between two of its points, the front is no better than the slower one's time and the faster
        // one's error.
        let mut stairs = vec![(first.0, top)];
        for pair in front.windows(2) {
            stairs.extend([pair[0], (pair[1].0, pair[0].1)]);
        }
        stairs.extend([last, (right, last.1)]);
        canvas.line(stairs, FRONT, 2)?;
    }
    for series in &chart.series {
        let placed: Vec<(i32, i32)> =
            series.points.iter().filter_map(|point| place(point.x, point.y)).collect();
        if series.connected {
            canvas.line(placed.clone(), series.mark.color(), 2)?;
        }
        for at in placed {
            mark(canvas, at, series.mark)?;
        }
    }
    tags(canvas, chart, &place)?;
    key(canvas, chart)
}

/// Numbers the points of the front and writes the notes of the others, a line further down where there is one already.
fn tags<DB: DrawingBackend>(
    canvas: &Canvas<DB>,
    chart: &Chart,
    place: &impl Fn(f64, f64) -> Option<(i32, i32)>,
) -> Drawn<DB> {
    const NOTE_WIDTH: i32 = 56;
    let mut taken: Vec<(i32, i32)> = Vec::new();
    let mut free = |(x, mut y): (i32, i32), width: i32| {
        while taken.iter().any(|&(left, top)| (left - x).abs() < width && (top - y).abs() < 13) {
            y += 13;
        }
        taken.push((x, y));
        (x, y)
    };
    for (number, point) in (1..).zip(chart.front()) {
        if let Some((x, y)) = place(point.x, point.y) {
            canvas.text(&number.to_string(), free((x - 9, y + 6), 16), 15, INK, HPos::Right)?;
        }
    }
    for point in chart.series.iter().flat_map(|series| &series.points) {
        if let (Some(note), Some((x, y))) = (&point.note, place(point.x, point.y)) {
            let x = (x + 10).min(PLOT.1 - NOTE_WIDTH);
            canvas.text(note, free((x, y - 16), NOTE_WIDTH), 14, INK, HPos::Left)?;
        }
    }
    Ok(())
}

/// Draws the meanings of marks and numbers.
fn key<DB: DrawingBackend>(canvas: &Canvas<DB>, chart: &Chart) -> Drawn<DB> {
    let (x, mut y) = (PLOT.1 + 22, PLOT.2);
    for group in &chart.key {
        canvas.text(&group.title, (x, y), 15, INK, HPos::Left)?;
        y += 22;
        for (sample, words) in &group.entries {
            mark(canvas, (x + 8, y + 5), *sample)?;
            canvas.text(words, (x + 24, y), 15, INK, HPos::Left)?;
            y += 20;
        }
        y += 8;
    }
    let front = chart.front();
    if !front.is_empty() {
        canvas.line([(x, y + 6), (x + 18, y + 6)], FRONT, 2)?;
        canvas.text("Pareto front", (x + 24, y), 15, INK, HPos::Left)?;
        y += 22;
    }
    let room = ((SIZE.1 as i32 - y - 20) / 17).max(0) as usize;
    let shown = if front.len() > room { room.saturating_sub(1) } else { front.len() };
    for (number, point) in (1..).zip(&front[..shown]) {
        canvas.text(&format!("{number}  {}", point.name), (x, y), 13, INK, HPos::Left)?;
        y += 17;
    }
    if shown < front.len() {
        canvas.text(
            &format!("and {} more, in the table", front.len() - shown),
            (x, y),
            13,
            INK,
            HPos::Left,
        )?;
    }
    Ok(())
}

/// Returns the corners of a regular polygon.
fn around((x, y): (i32, i32), corners: i32) -> Vec<(i32, i32)> {
    let corner = |step: i32| {
        let angle = f64::from(step) * std::f64::consts::TAU / f64::from(corners);
        (x + (6.0 * angle.cos()).round() as i32, y + (6.0 * angle.sin()).round() as i32)
    };
    (0..corners).map(corner).collect()
}

fn mark<DB: DrawingBackend>(canvas: &Canvas<DB>, (x, y): (i32, i32), mark: Mark) -> Drawn<DB> {
    let color = mark.color();
    let outline: Vec<(i32, i32)> = match mark.shape {
        Shape::Circle => around((x, y), 20),
        Shape::Hexagon => around((x, y), 6),
        Shape::Triangle => vec![(x, y - 7), (x + 7, y + 6), (x - 7, y + 6)],
        Shape::Wedge => vec![(x, y + 7), (x + 7, y - 6), (x - 7, y - 6)],
        Shape::Square => vec![(x - 5, y - 5), (x + 5, y - 5), (x + 5, y + 5), (x - 5, y + 5)],
        Shape::Diamond => vec![(x, y - 7), (x + 7, y), (x, y + 7), (x - 7, y)],
    };
    let fill = if mark.filled { color } else { WHITE };
    canvas.polygon(outline.clone(), fill)?;
    let closed: Vec<(i32, i32)> = outline.iter().chain(outline.first()).copied().collect();
    canvas.line(closed, color, 2)
}

impl Mark {
    fn color(&self) -> RGBColor {
        let [r, g, b] = self.rgb;
        RGBColor(r, g, b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_keep_order_and_leave_out_what_has_no_logarithm() {
        let axis = Axis::new(Scale::Log, [1.0, 10.0, 0.0, f64::NAN].into_iter(), 0, 1000);
        assert!(axis.pixel(1.0) < axis.pixel(2.0) && axis.pixel(2.0) < axis.pixel(10.0));
        assert_eq!((axis.pixel(0.0), axis.pixel(1e6)), (None, None));
        assert_eq!(axis.ticks(), [1.0, 2.0, 5.0, 10.0]);
        let narrow = Axis::new(Scale::Log, [25.0, 50.0].into_iter(), 0, 1000);
        assert_eq!(narrow.ticks(), [30.0, 40.0, 50.0]);
    }

    #[test]
    fn linear_ticks_are_round() {
        let axis = Axis::new(Scale::Linear, [1.0, 7.0].into_iter(), 0, 1000);
        assert_eq!(axis.ticks(), [2.0, 4.0, 6.0]);
    }

    #[test]
    fn tick_labels_are_short() {
        assert_eq!(
            [0.5, 100.0, 2e-4, 1e-6, 5e5, 2e7].map(short),
            ["0.5", "100", "2e-4", "1e-6", "500 k", "20 M"]
        );
    }
}
