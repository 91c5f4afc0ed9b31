//! What methods that aim at an error expect of it, against what comes out.

use super::chart::{Chart, KeyGroup, Mark, Point, Scale, Series, Shape};
use super::marks::COLORS;
use crate::results::Finished;

/// How far an expectation may be off, as a factor, to be called right.
pub const FACTOR: f64 = 3.0;

const GREY: [u8; 3] = [0x99; 3];

/// A point for every row that expects an error, a mark a scene; lines where both are equal and where they are [`FACTOR`]
/// apart. `None` where no row expects anything.
pub fn chart(title: String, rows: &[Finished]) -> Option<Chart> {
    let known = |row: &Finished| row.record.expected_nmse2.filter(|&expected| expected > 0.0);
    let mut scenes: Vec<&str> = Vec::new();
    let mut series: Vec<Series> = Vec::new();
    for (row, expected) in rows.iter().filter_map(|row| Some((row, known(row)?))) {
        let place = scenes.iter().position(|scene| *scene == row.setting).unwrap_or_else(|| {
            scenes.push(&row.setting);
            series.push(Series { mark: mark(series.len()), points: Vec::new(), connected: false });
            series.len() - 1
        });
        let point = Point { x: expected, y: row.record.nmse2, name: row.label.clone(), note: None };
        series[place].points.push(point);
    }
    let xs = || series.iter().flat_map(|series| &series.points).map(|point| point.x);
    let (low, high) = (xs().fold(f64::INFINITY, f64::min), xs().fold(0.0, f64::max));
    if series.is_empty() {
        return None;
    }
    let entries = series.iter().zip(&scenes).map(|(one, scene)| (one.mark, (*scene).to_string())).collect();
    let line = |factor: f64| {
        let end = |x: f64| Point { x, y: x * factor, name: format!("{factor:.2} times"), note: None };
        let mark = Mark { shape: Shape::Circle, rgb: GREY, filled: false };
        Series { mark, points: vec![end(low), end(high)], connected: true }
    };
    series.extend([1.0 / FACTOR, 1.0, FACTOR].map(line));
    Some(Chart {
        title,
        x_label: "NMSE₂ expected".to_string(),
        y_label: "NMSE₂ that comes out".to_string(),
        x_scale: Scale::Log,
        series,
        key: vec![KeyGroup { title: format!("Lines: equal, and {FACTOR} times apart"), entries }],
        noise: None,
        pareto: false,
    })
}

fn mark(index: usize) -> Mark {
    let shape = Shape::ALL[index / COLORS.len() % Shape::ALL.len()];
    Mark { shape, rgb: COLORS[index % COLORS.len()], filled: true }
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
