//! Shapes of marks, and the colour of fronts.

use plotters::prelude::*;

use super::canvas::{Canvas, Drawn};
use super::chart::{Mark, Shape};

/// Colour of the line that joins the best rows.
pub(super) const FRONT: RGBColor = RGBColor(120, 120, 120);

/// Draws a mark about a point.
pub(super) fn mark<DB: DrawingBackend>(canvas: &Canvas<DB>, (x, y): (i32, i32), mark: Mark) -> Drawn<DB> {
    let color = mark.color();
    let outline: Vec<(i32, i32)> = match mark.shape {
        Shape::Circle => around((x, y), 20, 6.0),
        Shape::Hexagon => around((x, y), 6, 6.0),
        Shape::Dot => around((x, y), 12, 3.0),
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

/// Returns the corners of a regular polygon.
fn around((x, y): (i32, i32), corners: i32, radius: f64) -> Vec<(i32, i32)> {
    let corner = |step: i32| {
        let angle = f64::from(step) * std::f64::consts::TAU / f64::from(corners);
        (x + (radius * angle.cos()).round() as i32, y + (radius * angle.sin()).round() as i32)
    };
    (0..corners).map(corner).collect()
}
