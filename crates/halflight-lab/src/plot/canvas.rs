//! Lines, polygons and text in units that SVG and PNG share.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Usual size of a chart, units. A unit is a pixel in SVG and more of them in PNG.
pub(super) const SIZE: (u32, u32) = (1400, 760);
pub(super) const FONT: &str = "sans-serif";
pub(super) const INK: RGBColor = RGBColor(34, 34, 34);
pub(super) const NOISE: RGBColor = RGBColor(170, 60, 60);

/// Drawing area in units.
pub struct Canvas<'a, DB: DrawingBackend> {
    /// Area in pixels.
    pub(crate) area: &'a DrawingArea<DB, Shift>,
    /// Pixels a unit.
    pub(crate) scale: i32,
}

pub(crate) type Drawn<DB> = Result<(), DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>>;

impl<DB: DrawingBackend> Canvas<'_, DB> {
    pub(super) fn line(
        &self,
        points: impl IntoIterator<Item = (i32, i32)>,
        color: RGBColor,
        width: u32,
    ) -> Drawn<DB> {
        let width = width * self.scale.unsigned_abs();
        self.area.draw(&PathElement::new(self.pixels(points), color.stroke_width(width)))
    }

    pub(super) fn polygon(
        &self,
        corners: impl IntoIterator<Item = (i32, i32)>,
        color: RGBColor,
    ) -> Drawn<DB> {
        self.area.draw(&Polygon::new(self.pixels(corners), color))
    }

    pub(super) fn text(
        &self,
        words: &str,
        (x, y): (i32, i32),
        size: i32,
        color: RGBColor,
        side: HPos,
    ) -> Drawn<DB> {
        let style = (FONT, size * self.scale).into_font().color(&color).pos(Pos::new(side, VPos::Top));
        self.area.draw(&Text::new(words.to_string(), (x * self.scale, y * self.scale), style))
    }

    fn pixels(&self, points: impl IntoIterator<Item = (i32, i32)>) -> Vec<(i32, i32)> {
        points.into_iter().map(|(x, y)| (x * self.scale, y * self.scale)).collect()
    }
}
