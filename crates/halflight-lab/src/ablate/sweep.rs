//! Errors against one constant of a backend.

use super::chart::{self, Chart, KeyGroup, Mark, Point, Scale, Series, Shape};
use super::record::Finished;

/// What a row's parameters set the constant to, if they set it alone and to a number.
pub fn value(parameters: &str, constant: &str) -> Option<f64> {
    let (name, value) = parameters.split_once('=')?;
    (name == constant).then(|| value.parse().ok())?
}

/// NMSE₂, and the share of receivers that are off where it is known, against the constant; a level line shows NMSE₂ of
/// exact visibility where there is a row with as many samples. `None` where fewer than two rows of a setting set it alone.
pub fn chart(title: String, rows: &[&Finished], constant: &str) -> Option<Chart> {
    let mut swept: Vec<(f64, &Finished)> =
        rows.iter().filter_map(|row| Some((value(&row.record.parameters, constant)?, *row))).collect();
    swept.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [(low, first), .., (high, _)] = swept.as_slice() else { return None };
    let point = |x: f64, y: f64, row: &Finished| Point { x, y, name: row.label.clone(), note: None };
    let mut curves = vec![(
        Shape::Circle,
        format!("NMSE₂, {}", first.record.visibility),
        swept.iter().map(|&(x, row)| point(x, row.record.nmse2, row)).collect::<Vec<Point>>(),
    )];
    let off = swept.iter().filter_map(|&(x, row)| Some(point(x, row.record.off_share?, row)));
    curves.push((Shape::Triangle, "share of receivers off by more than 0.1".to_string(), off.collect()));
    let exact =
        rows.iter().find(|row| row.record.visibility == "bvh" && row.record.samples == first.record.samples);
    let level = exact.iter().flat_map(|row| [low, high].map(|&x| point(x, row.record.nmse2, row)));
    curves.push((Shape::Square, "NMSE₂, bvh".to_string(), level.collect()));
    curves.retain(|(_, _, points)| !points.is_empty());
    let marked = |(place, (shape, words, points)): (usize, (Shape, String, Vec<Point>))| {
        let mark = Mark { shape, rgb: chart::COLORS[place], filled: true };
        (Series { mark, points, connected: true }, (mark, words))
    };
    let (series, entries) = curves.into_iter().enumerate().map(marked).unzip();
    Some(Chart {
        title,
        x_label: constant.to_string(),
        y_label: "error".to_string(),
        x_scale: Scale::Log,
        series,
        key: vec![KeyGroup { title: "Error".to_string(), entries }],
        noise: None,
        pareto: false,
    })
}

#[cfg(test)]
mod tests {
    use super::super::record::tests::finished;
    use super::*;

    #[test]
    fn a_constant_set_alone_has_a_value() {
        assert_eq!(value("resolution=128", "resolution"), Some(128.0));
        for other in ["", "resolution=128;bias=2", "depth_bits=128", "resolution=fine"] {
            assert_eq!(value(other, "resolution"), None, "{other}");
        }
    }

    #[test]
    fn curves_are_those_that_have_points() {
        let mut rows = Vec::new();
        for (resolution, off) in [(256, None), (32, Some(0.5)), (128, Some(0.125))] {
            let mut row = finished("full", "bilinear", 1.0, 1.0 / f64::from(resolution));
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
        rows.push(finished("full", "bilinear", 1.0, 1e-6));
        let chart = chart_of(&rows).unwrap();
        assert_eq!(places(&chart)[2], [32.0, 256.0]);
        assert!(chart.svg().unwrap().contains("share of receivers off"));
        assert!(chart_of(&rows[..1]).is_none());
    }
}
