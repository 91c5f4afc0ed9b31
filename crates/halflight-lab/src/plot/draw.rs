//! Drawing of charts of points.

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::axis::{Axis, short};
use super::canvas::{Canvas, Drawn, INK, NOISE};
use super::chart::{Chart, Mark, Scale};
use super::drawing::Drawing;
use super::key::{key, tags};
use super::layout::Layout;
use super::shape::{FRONT, mark};

const GRID: RGBColor = RGBColor(228, 228, 228);

impl Drawing for Chart {
    fn title(&self) -> &str {
        &self.title
    }

    fn size(&self) -> (u32, u32) {
        self.layout.size
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn<DB> {
        draw(canvas, self)
    }
}

/// Draws a chart.
fn draw<DB: DrawingBackend>(canvas: &Canvas<DB>, chart: &Chart) -> Drawn<DB> {
    canvas.area.fill(&WHITE)?;
    let Layout { plot: (left, right, top, bottom), title, label, tick: small, .. } = chart.layout;
    let points = || chart.series.iter().flat_map(|series| &series.points);
    let x_axis = Axis::new(chart.x_scale, points().map(|point| point.x), left, right);
    let noise = chart.noise.into_iter();
    let y_axis = Axis::new(Scale::Log, points().map(|point| point.y).chain(noise), bottom, top);

    canvas.text(&chart.title, (left, 14), title, INK, HPos::Left)?;
    canvas.text(&chart.y_label, (left - 60, top - label - 9), label, INK, HPos::Left)?;
    canvas.text(&chart.x_label, (right, bottom + 18 + small), label, INK, HPos::Right)?;
    for tick in x_axis.ticks() {
        if let Some(x) = x_axis.pixel(tick) {
            canvas.line([(x, top), (x, bottom)], GRID, 1)?;
            canvas.text(&short(tick), (x, bottom + 8), small, INK, HPos::Center)?;
        }
    }
    for tick in y_axis.ticks() {
        if let Some(y) = y_axis.pixel(tick) {
            canvas.line([(left, y), (right, y)], GRID, 1)?;
            canvas.text(&short(tick), (left - 8, y - small / 2), small, INK, HPos::Right)?;
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
        canvas.text(&words, (left + 8, y - 4 - small), small, NOISE, HPos::Left)?;
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
        if series.connected {
            let line = series.points.iter().filter_map(|point| place(point.x, point.y));
            canvas.line(line, series.mark.color(), 2)?;
        }
    }
    for series in &chart.series {
        for at in series.points.iter().filter_map(|point| place(point.x, point.y)) {
            mark(canvas, at, series.mark)?;
        }
    }
    tags(canvas, chart, &place)?;
    key(canvas, chart)
}

impl Mark {
    pub(super) fn color(&self) -> RGBColor {
        let [r, g, b] = self.rgb;
        RGBColor(r, g, b)
    }
}
