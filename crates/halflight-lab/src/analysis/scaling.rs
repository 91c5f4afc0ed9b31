//! Growth of time: rows that differ in one quantity, and the exponents of power laws fitted to them.

use indexmap::IndexMap;
use itertools::Itertools as _;

use crate::experiment::Axis;
use crate::results::{Finished, Record, Table};

/// Power law `y = c · x^exponent` through points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerLaw {
    /// Slope of the least-squares line in log–log space.
    pub exponent: f64,
    /// Standard error of the slope; `None` of two points.
    pub error: Option<f64>,
}

impl PowerLaw {
    /// Fits a power law by least squares of `ln y` over `ln x`; points that are not positive have no logarithm and
    /// are left out. `None` where fewer than two different x are left.
    pub fn fit(points: &[(f64, f64)]) -> Option<Self> {
        let logarithms = points.iter().map(|&(x, y)| (x.ln(), y.ln()));
        let points: Vec<(f64, f64)> = logarithms.filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
        let count = points.len() as f64;
        let mean = |part: fn(&(f64, f64)) -> f64| points.iter().map(part).sum::<f64>() / count;
        let (x_mean, y_mean) = (mean(|point| point.0), mean(|point| point.1));
        let sum = |part: &dyn Fn(f64, f64) -> f64| -> f64 {
            points.iter().map(|&(x, y)| part(x - x_mean, y - y_mean)).sum()
        };
        let spread = sum(&|x, _| x * x);
        // Rounding moves equal x by far less than any two counts differ.
        if points.len() < 2 || spread < 1e-12 {
            return None;
        }
        let exponent = sum(&|x, y| x * y) / spread;
        let left = sum(&|x, y| (y - exponent * x).powi(2));
        let error = (points.len() > 2).then(|| (left / (count - 2.0) / spread).sqrt());
        Some(Self { exponent, error })
    }

    /// Returns a fit in words.
    pub fn words(law: Option<Self>) -> String {
        match law {
            None => "no slope".to_string(),
            Some(Self { exponent, error: None }) => format!("slope {exponent:.2}"),
            Some(Self { exponent, error: Some(error) }) => format!("slope {exponent:.2} ± {error:.2}"),
        }
    }
}

impl Axis {
    /// Returns the name of the quantity.
    pub fn quantity(self) -> &'static str {
        match self {
            Self::Samples => "light samples",
            Self::Triangles => "triangles",
            Self::Pixels => "pixels",
        }
    }

    /// Returns the value in a row.
    pub fn of(self, record: &Record) -> f64 {
        match self {
            Self::Samples => f64::from(record.samples),
            Self::Triangles => record.triangles as f64,
            Self::Pixels => f64::from(record.width) * f64::from(record.height),
        }
    }

    /// Returns all that rows of one line have in common: backend, scene, and the rest, with nothing for the axis itself.
    fn common(self, record: &Record) -> Common {
        let unless = |axis: Self, words: String| if self == axis { String::new() } else { words };
        let scene = if self == Self::Triangles { record.scene_name() } else { &record.scene };
        [
            record.visibility.clone(),
            scene.to_string(),
            record.refiner.clone(),
            record.parameters.clone(),
            unless(Self::Samples, format!("{} samples", record.samples)),
            unless(Self::Pixels, format!("{}×{}", record.width, record.height)),
            format!("{}/{}", record.pattern, record.sharing),
            record.shading.clone(),
            format!("light ×{}", record.light_scale),
        ]
    }
}

type Common = [String; 9];

/// Rows that differ in the axis alone, by ascending x.
#[derive(Clone, Debug, PartialEq)]
pub struct Growth {
    /// Visibility backend.
    pub visibility: String,
    /// Scene, without the parameter that varies.
    pub scene: String,
    /// Other choices that tell the line from the others.
    pub rest: String,
    /// Values of the axis, and milliseconds of the visibility stage.
    pub points: Vec<(f64, f64)>,
    /// Power law through the points.
    pub law: Option<PowerLaw>,
}

/// Returns the lines of all rows, in the order of their first rows.
pub fn lines(rows: &[Finished], axis: Axis) -> Vec<Growth> {
    let mut groups: IndexMap<Common, Vec<(f64, f64)>> = IndexMap::new();
    for Finished { record, .. } in rows {
        groups.entry(axis.common(record)).or_default().push((axis.of(record), record.visibility_ms));
    }
    let varies: [bool; 9] =
        std::array::from_fn(|part| !groups.keys().map(|common| &common[part]).all_equal());
    let line = |(common, mut points): (Common, Vec<(f64, f64)>)| {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let rest = common.iter().zip(&varies).skip(2).filter(|(part, varies)| **varies && !part.is_empty());
        Growth {
            rest: rest.map(|(part, _)| part).join(", "),
            law: PowerLaw::fit(&points),
            points,
            visibility: common[0].clone(),
            scene: common[1].clone(),
        }
    };
    groups.into_iter().map(line).collect()
}

/// Returns a table of the slopes.
pub fn table(lines: &[Growth], axis: Axis) -> Table {
    let columns = ["visibility", "scene", "rest", "axis", "from", "to", "points", "slope", "standard error"];
    let end = |point: Option<&(f64, f64)>| point.map_or(String::new(), |point| point.0.to_string());
    let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.4}"));
    let cells = lines.iter().map(|line| {
        [
            line.visibility.clone(),
            line.scene.clone(),
            line.rest.clone(),
            axis.quantity().to_string(),
            end(line.points.first()),
            end(line.points.last()),
            line.points.len().to_string(),
            number(line.law.map(|law| law.exponent)),
            number(line.law.and_then(|law| law.error)),
        ]
    });
    Table::new(columns, cells)
}

impl Growth {
    /// Returns the line's name.
    pub fn name(&self) -> String {
        let mut name = format!("{}, {}", self.visibility, self.scene);
        if !self.rest.is_empty() {
            name.push_str(&format!(", {}", self.rest));
        }
        name
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::results::record::tests::finished;

    #[test]
    fn a_power_law_gives_its_exponent() {
        for exponent in [-1.5, 0.0, 0.5, 1.0] {
            let points: Vec<(f64, f64)> =
                [64.0, 256.0, 1024.0, 4096.0].iter().map(|&x: &f64| (x, 3.0 * x.powf(exponent))).collect();
            let law = PowerLaw::fit(&points).unwrap();
            // A few roundings of logarithms below 10.
            assert!((law.exponent - exponent).abs() < 1e-13, "{law:?}");
            assert!(law.error.unwrap() < 1e-13, "{law:?}");
        }
    }

    #[test]
    fn scatter_is_fitted_by_least_squares_and_shows_in_the_error() {
        // ln y is 0, 2, 1 at ln x = 0, 1, 2: slope 1/2, residuals -1/2, 1, -1/2, so that the error is √(3/2 / 1 / 2).
        let points = [(0.0, 0.0), (1.0, 2.0), (2.0, 1.0)].map(|(x, y): (f64, f64)| (x.exp(), y.exp()));
        let law = PowerLaw::fit(&points).unwrap();
        assert!((law.exponent - 0.5).abs() < 1e-13, "{law:?}");
        assert!((law.error.unwrap() - 0.75f64.sqrt()).abs() < 1e-13, "{law:?}");
    }

    #[test]
    fn too_few_points_have_no_slope() {
        for points in
            [&[][..], &[(2.0, 3.0)], &[(2.0, 3.0), (2.0, 5.0)], &[(2.0, 3.0), (4.0, 0.0), (-1.0, 2.0)]]
        {
            assert_eq!(PowerLaw::fit(points), None, "{points:?}");
        }
        let two = PowerLaw::fit(&[(1.0, 1.0), (10.0, 100.0)]).unwrap();
        assert!((two.exponent - 2.0).abs() < 1e-13 && two.error.is_none());
    }

    pub(crate) fn rows() -> Vec<Finished> {
        let mut rows = Vec::new();
        for (visibility, factor, exponent) in [("bvh", 0.1, 1.0), ("raster4d", 1.0, 0.5)] {
            // Not in ascending order.
            for samples in [1024, 64, 256] {
                let mut row = finished("per-pixel", "bilinear", 1.0, 1e-4);
                row.record.visibility = visibility.to_string();
                row.record.samples = samples;
                row.record.visibility_ms = factor * f64::from(samples).powf(exponent);
                rows.push(row);
            }
        }
        rows
    }

    #[test]
    fn every_backend_has_its_line_and_slope() {
        let lines = lines(&rows(), Axis::Samples);
        let words: Vec<String> = lines.iter().map(|line| PowerLaw::words(line.law)).collect();
        assert_eq!(words, ["slope 1.00 ± 0.00", "slope 0.50 ± 0.00"]);
        assert!(lines.iter().all(|line| line.points.is_sorted() && line.rest.is_empty()));
        let table = table(&lines, Axis::Samples);
        assert_eq!(table.lines[1].cells[4..8], ["64", "1024", "3", "0.5000"]);
    }

    #[test]
    fn what_differs_besides_the_axis_makes_lines_of_its_own() {
        let by_triangles = lines(&rows(), Axis::Triangles);
        assert_eq!(by_triangles.len(), 6);
        assert!(by_triangles.iter().all(|line| line.rest.ends_with("samples") && line.law.is_none()));
        let mut rows = rows();
        rows[0].record.scene = "hall triangles=1000".to_string();
        rows[0].record.triangles = 1000;
        assert_eq!(lines(&rows, Axis::Triangles)[0].scene, "hall");
    }
}
