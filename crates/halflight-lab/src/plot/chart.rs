//! Charts of points as data.

use super::layout::Layout;
use crate::analysis::pareto;

/// Chart with a logarithmic y axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Title.
    pub title: String,
    /// Quantity and unit on x.
    pub x_label: String,
    /// Quantity on y.
    pub y_label: String,
    /// Scale of x.
    pub x_scale: Scale,
    /// Points, by their marks.
    pub series: Vec<Series>,
    /// Meanings of the marks.
    pub key: Vec<KeyGroup>,
    /// Error of the reference itself, drawn as a line.
    pub noise: Option<f64>,
    /// Set to draw the Pareto front.
    pub pareto: bool,
    /// Sizes of plot and letters, and place of the key.
    pub layout: Layout,
}

/// Scale of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Even.
    Linear,
    /// By powers of ten.
    Log,
}

/// Points with one mark.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Mark of the points.
    pub mark: Mark,
    /// Points, in the order in which a line joins them.
    pub points: Vec<Point>,
    /// Set to join the points by a line.
    pub connected: bool,
}

/// Row in a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Time, rays, size or another quantity.
    pub x: f64,
    /// Error, or another quantity above 0.
    pub y: f64,
    /// Name of the row.
    pub name: String,
    /// Word beside the point.
    pub note: Option<String>,
}

/// Mark of points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Mark {
    /// Outline.
    pub shape: Shape,
    /// Colour, sRGB.
    pub rgb: [u8; 3],
    /// Filled or hollow.
    pub filled: bool,
}

/// Outline of a mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shape {
    /// Circle.
    Circle,
    /// Triangle on its base.
    Triangle,
    /// Square.
    Square,
    /// Square on its corner.
    Diamond,
    /// Triangle on its tip.
    Wedge,
    /// Hexagon.
    Hexagon,
    /// Small circle, for rows that no one needs to tell apart.
    Dot,
}

/// Part of a key.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyGroup {
    /// Quantity that varies.
    pub title: String,
    /// Marks and meanings.
    pub entries: Vec<(Mark, String)>,
}

/// Colours of Okabe and Ito, told apart by the colour-blind as well, and two more.
pub(super) const COLORS: [[u8; 3]; 8] = [
    [0xE6, 0x9F, 0x00],
    [0xCC, 0x79, 0xA7],
    [0xD5, 0x5E, 0x00],
    [0x00, 0x72, 0xB2],
    [0x00, 0x9E, 0x73],
    [0x56, 0xB4, 0xE9],
    [0x99, 0x99, 0x33],
    [0x33, 0x22, 0x88],
];

impl Shape {
    /// Shapes that are told apart.
    pub const ALL: [Self; 6] =
        [Self::Circle, Self::Triangle, Self::Square, Self::Diamond, Self::Wedge, Self::Hexagon];

    /// Returns one of the shapes, again from the first after the last.
    pub(super) fn nth(index: usize) -> Self {
        Self::ALL[index % Self::ALL.len()]
    }
}

impl Mark {
    /// Returns a filled mark.
    pub(super) fn filled(shape: Shape, rgb: [u8; 3]) -> Self {
        Self { shape, rgb, filled: true }
    }

    /// Returns the mark with this number: all colours of one shape, then those of the next.
    pub(super) fn nth(index: usize) -> Self {
        Self::filled(Shape::nth(index / COLORS.len()), COLORS[index % COLORS.len()])
    }
}

impl Point {
    /// Returns a point without a note.
    pub(super) fn new(x: f64, y: f64, name: impl Into<String>) -> Self {
        Self { x, y, name: name.into(), note: None }
    }
}

impl Series {
    /// Returns points that a line joins.
    pub(super) fn line(mark: Mark, points: impl IntoIterator<Item = Point>) -> Self {
        Self { mark, points: points.into_iter().collect(), connected: true }
    }
}

impl Chart {
    /// Returns a chart with a logarithmic x axis and one group in its key.
    pub(super) fn new(
        title: impl Into<String>,
        [x_label, y_label]: [&str; 2],
        series: Vec<Series>,
        (key, entries): (impl Into<String>, Vec<(Mark, String)>),
    ) -> Self {
        Self {
            title: title.into(),
            x_label: x_label.to_string(),
            y_label: y_label.to_string(),
            x_scale: Scale::Log,
            series,
            key: vec![KeyGroup { title: key.into(), entries }],
            noise: None,
            pareto: false,
            layout: Layout::PAGE,
        }
    }

    /// Returns the points that no other beats, by ascending x; none where no front is drawn.
    pub fn front(&self) -> Vec<&Point> {
        if !self.pareto {
            return Vec::new();
        }
        let points: Vec<&Point> = self.series.iter().flat_map(|series| &series.points).collect();
        let places: Vec<(f64, f64)> = points.iter().map(|point| (point.x, point.y)).collect();
        pareto::front(&places).into_iter().map(|index| points[index]).collect()
    }
}
