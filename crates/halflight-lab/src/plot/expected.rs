//! Charts of the error that methods with an error target expect against the error that comes out.

use indexmap::IndexMap;

use super::chart::{Chart, Mark, Point, Series, Shape};
use crate::results::Finished;

/// Factor within which an expectation is called right.
pub const FACTOR: f64 = 3.0;

const GREY: [u8; 3] = [0x99; 3];

/// Returns a chart with a point for every row that expects an error and a mark for each scene; lines where both are equal and
/// where they are [`FACTOR`] apart. `None` where no row expects anything.
pub fn chart(title: String, rows: &[Finished]) -> Option<Chart> {
    let known = |row: &Finished| row.record.expected_nmse2.filter(|&expected| expected > 0.0);
    let mut scenes: IndexMap<&str, Vec<Point>> = IndexMap::new();
    for (row, expected) in rows.iter().filter_map(|row| Some((row, known(row)?))) {
        let points = scenes.entry(&row.setting).or_default();
        points.push(Point::new(expected, row.record.nmse2, row.label.clone()));
    }
    if scenes.is_empty() {
        return None;
    }
    let xs = || scenes.values().flatten().map(|point| point.x);
    let (low, high) = (xs().fold(f64::INFINITY, f64::min), xs().fold(0.0, f64::max));
    let line = |factor: f64| {
        let end = |x: f64| Point::new(x, x * factor, format!("{factor:.2} times"));
        let mark = Mark { shape: Shape::Circle, rgb: GREY, filled: false };
        Series::line(mark, [low, high].map(end))
    };
    let lines = [1.0 / FACTOR, 1.0, FACTOR].map(line);
    let entries =
        scenes.keys().enumerate().map(|(index, scene)| (Mark::nth(index), (*scene).to_string())).collect();
    let marked = |(index, points)| Series { mark: Mark::nth(index), points, connected: false };
    let series = scenes.into_values().enumerate().map(marked).chain(lines).collect();
    let key = format!("Lines: equal, and {FACTOR} times apart");
    Some(Chart::new(title, ["NMSE₂ expected", "NMSE₂ that comes out"], series, (key, entries)))
}

#[cfg(test)]
mod tests {
    use super::super::Drawing as _;
    use super::*;
    use crate::results::record::tests::finished;

    #[test]
    fn rows_that_expect_something_are_points_between_lines() {
        let row = |scene: &str, expected: Option<f64>, found: f64| {
            let mut row = finished("lattice", "lattice", 10.0, found);
            row.setting = scene.to_string();
            row.record.expected_nmse2 = expected;
            row
        };
        let rows = [
            row("hall", Some(1e-4), 2e-4),
            row("hall", None, 3e-4),
            row("tree", Some(1e-3), 5e-4),
            row("hall", Some(1e-5), 4e-5),
        ];
        let chart = chart("Expected".to_string(), &rows).unwrap();
        let places = |index: usize| -> Vec<(f64, f64)> {
            chart.series[index].points.iter().map(|point| (point.x, point.y)).collect()
        };
        assert_eq!(places(0), [(1e-4, 2e-4), (1e-5, 4e-5)]);
        assert_eq!(places(1), [(1e-3, 5e-4)]);
        assert_eq!(places(3), [(1e-5, 1e-5), (1e-3, 1e-3)]);
        assert_eq!((chart.series.len(), chart.key[0].entries.len()), (5, 2));
        assert!(chart.svg().unwrap().contains("NMSE₂ expected"));
        assert!(super::chart("None".to_string(), &rows[1..2]).is_none());
    }
}
