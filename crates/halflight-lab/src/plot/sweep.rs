//! Charts of errors against one constant of a backend.

use super::chart::{COLORS, Chart, Mark, Point, Series, Shape};
use crate::analysis::sweep::{Curve, curves};
use crate::reference::voxel_errors::OFF;
use crate::results::Finished;

/// Returns a chart of NMSE₂, and of the share of receivers that are off where it is known, against a constant: one colour for
/// each set of other constants. A level line shows NMSE₂ of exact visibility where there is a row with as many samples.
/// `None` where no two rows of the setting differ in the constant alone.
pub fn chart(title: String, rows: &[&Finished], constant: &str) -> Option<Chart> {
    let curves = curves(rows, constant);
    let all = || curves.iter().flat_map(|curve| &curve.points);
    let samples = all().next()?.1.record.samples;
    let point = |x: f64, y: f64, row: &Finished| Point::new(x, y, row.label.clone());
    let mut lines: Vec<(Shape, String, Vec<Point>)> = Vec::new();
    for Curve { name, points } in &curves {
        let error = points.iter().map(|&(x, row)| point(x, row.record.nmse2, row));
        lines.push((Shape::Circle, format!("NMSE₂, {name}"), error.collect()));
        let off = points.iter().filter_map(|&(x, row)| Some(point(x, row.record.off_share?, row)));
        lines.push((Shape::Triangle, format!("off by > {OFF}, {name}"), off.collect()));
    }
    let exact = rows.iter().find(|row| row.record.visibility == "bvh" && row.record.samples == samples);
    let (low, high) = all().fold((f64::MAX, f64::MIN), |(low, high), (x, _)| (low.min(*x), high.max(*x)));
    let level = exact.iter().flat_map(|row| [low, high].map(|x| point(x, row.record.nmse2, row)));
    lines.push((Shape::Square, "NMSE₂, bvh".to_string(), level.collect()));
    let marked = |(place, (shape, words, points)): (usize, (Shape, String, Vec<Point>))| {
        // Both lines of a curve have its colour.
        let mark = Mark::filled(shape, COLORS[place / 2 % COLORS.len()]);
        (Series::line(mark, points), (mark, words))
    };
    let shown = lines.into_iter().enumerate().filter(|(_, (_, _, points))| !points.is_empty());
    let (series, entries) = shown.map(marked).unzip();
    let y_label = "NMSE₂, and the share of receivers whose visible fraction is off";
    Some(Chart::new(title, [constant, y_label], series, ("Error", entries)))
}

/// Returns a chart of the frame's time against a constant: one colour for each set of other constants. `None` where no two rows of the setting
/// differ in the constant alone.
pub fn times(title: String, rows: &[&Finished], constant: &str) -> Option<Chart> {
    let curves = curves(rows, constant);
    let line = |(place, curve): (usize, &Curve)| {
        let mark = Mark::nth(place);
        let points =
            curve.points.iter().map(|&(x, row)| Point::new(x, row.record.total_ms, row.label.clone()));
        (Series::line(mark, points), (mark, curve.name.clone()))
    };
    let (series, entries): (Vec<_>, Vec<_>) = curves.iter().enumerate().map(line).unzip();
    let labels = [constant, "time of the frame, ms"];
    (!series.is_empty()).then(|| Chart::new(title, labels, series, ("Time", entries)))
}

#[cfg(test)]
mod tests {
    use super::super::Drawing as _;
    use super::*;
    use crate::results::record::tests::finished;

    #[test]
    fn curves_are_those_that_have_points() {
        let mut rows = Vec::new();
        for (resolution, off) in [(256, None), (32, Some(0.5)), (128, Some(0.125))] {
            let mut row = finished("per-pixel", "bilinear", 1.0, 1.0 / f64::from(resolution));
            row.record.visibility = "voxel".to_string();
            row.record.parameters = format!("resolution={resolution}");
            row.record.off_share = off;
            rows.push(row);
        }
        let chart_of =
            |rows: &[Finished]| chart("t".to_string(), &rows.iter().collect::<Vec<_>>(), "resolution");
        let places = |chart: &Chart| -> Vec<Vec<f64>> {
            chart.series.iter().map(|series| series.points.iter().map(|point| point.x).collect()).collect()
        };
        assert_eq!(places(&chart_of(&rows).unwrap()), [vec![32.0, 128.0, 256.0], vec![32.0, 128.0]]);
        rows.push(finished("per-pixel", "bilinear", 1.0, 1e-6));
        let chart = chart_of(&rows).unwrap();
        assert_eq!(places(&chart)[2], [32.0, 256.0]);
        assert!(chart.svg().unwrap().contains("off by &gt; 0.1, voxel"));
        assert!(chart_of(&rows[..1]).is_none());
        let times =
            |rows: &[Finished]| times("t".to_string(), &rows.iter().collect::<Vec<_>>(), "resolution");
        let found = times(&rows).unwrap();
        assert_eq!(found.series[0].points.iter().map(|point| point.y).collect::<Vec<_>>(), [1.0; 3]);
        assert!(times(&rows[..1]).is_none());
        // With another bias it is another curve, which one point does not make.
        rows[2].record.parameters.push_str(";bias=2");
        assert_eq!(places(&chart_of(&rows).unwrap())[0], [32.0, 256.0]);
    }
}
