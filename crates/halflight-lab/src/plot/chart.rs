//! Charts of points as data.

use crate::analysis::pareto;

/// A chart; y has a logarithmic scale.
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
    /// What is shown.
    pub series: Vec<Series>,
    /// What the marks mean.
    pub key: Vec<KeyGroup>,
    /// The reference's own error, drawn as a line.
    pub noise: Option<f64>,
    /// Whether to draw the Pareto front.
    pub pareto: bool,
}

/// How an axis spreads its quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// By powers of ten.
    Log,
}

/// Points with one mark.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// How they are marked.
    pub mark: Mark,
    /// The points.
    pub points: Vec<Point>,
    /// Whether a line joins them.
    pub connected: bool,
}

/// A row in a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Such as time, rays or size.
    pub x: f64,
    /// Such as an error.
    pub y: f64,
    /// The row.
    pub name: String,
    /// A word beside it.
    pub note: Option<String>,
}

/// A mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Mark {
    /// Outline.
    pub shape: Shape,
    /// Colour, sRGB.
    pub rgb: [u8; 3],
    /// Filled or hollow.
    pub filled: bool,
}

/// The outline of a mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shape {
    /// A circle.
    Circle,
    /// A triangle on its base.
    Triangle,
    /// A square.
    Square,
    /// A square on its corner.
    Diamond,
}

/// Part of a key.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyGroup {
    /// What varies.
    pub title: String,
    /// Marks and meanings.
    pub entries: Vec<(Mark, String)>,
}

impl Shape {
    /// All shapes.
    pub const ALL: [Self; 4] = [Self::Circle, Self::Triangle, Self::Square, Self::Diamond];
}

impl Scale {
    pub(crate) fn apply(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Log => value.log10(),
        }
    }
}

impl Chart {
    /// The points that no other beats, by ascending x; none where no front is drawn.
    pub fn front(&self) -> Vec<&Point> {
        if !self.pareto {
            return Vec::new();
        }
        let points: Vec<&Point> = self.series.iter().flat_map(|series| &series.points).collect();
        let places: Vec<(f64, f64)> = points.iter().map(|point| (point.x, point.y)).collect();
        pareto::front(&places).into_iter().map(|index| points[index]).collect()
    }
}
