//! Charts of an error against time, rays or the size of the light.

use itertools::Itertools as _;

use super::chart::{Chart, Point, Scale, Series};
use super::layout::Layout;
use super::marks::Marks;
use crate::analysis::Measure;
use crate::results::Finished;

/// Quantity that a chart sets the error against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Against {
    /// Time of a frame.
    Time,
    /// Shadow rays of a frame.
    Rays,
    /// Size of the light; rows that differ in nothing else are joined.
    Light,
}

/// Returns a chart of an error of these rows; those are left out for which it was not measured. `None` where no row is left.
pub fn chart(title: String, rows: &[&Finished], measure: Measure, against: Against) -> Option<Chart> {
    let rows: Vec<&Finished> = rows.iter().copied().filter(|row| measure.of(row).is_some()).collect();
    if rows.is_empty() {
        return None;
    }
    let marks = Marks::of(&rows);
    let light = against == Against::Light;
    let x = |row: &Finished| match against {
        Against::Time => row.record.total_ms,
        Against::Rays => row.record.rays as f64,
        Against::Light => f64::from(row.record.light_scale),
    };
    // Refiners whose rows differ in samples a pixel.
    let by_samples = |row: &Finished| ["per-pixel", "filtered"].contains(&row.record.refiner.as_str());
    let counted = rows.iter().filter(|row| by_samples(row));
    let several = !counted.map(|row| row.record.samples).all_equal();
    let mut series: Vec<(&str, Series)> = Vec::new();
    for row in &rows {
        let note = (by_samples(row) && several).then(|| format!("{} spp", row.record.samples));
        let Some(y) = measure.of(row) else { continue };
        let point = Point { x: x(row), y, name: row.label.clone(), note };
        match series.iter_mut().find(|(name, _)| *name == row.row) {
            Some((_, series)) if light => series.points.push(point),
            _ => {
                let one = Series { mark: marks.mark(row), points: vec![point], connected: light };
                series.push((&row.row, one));
            }
        }
    }
    let (x_label, x_scale) = match against {
        Against::Time => ("time of a frame, ms", Scale::Log),
        Against::Rays => ("shadow rays of a frame", Scale::Log),
        Against::Light => ("light's edge, in parts of the scene file's", Scale::Linear),
    };
    let noise = rows.iter().filter_map(|row| measure.noise(row)).fold(0.0, f64::max);
    Some(Chart {
        title,
        x_label: x_label.to_string(),
        y_label: measure.label().to_string(),
        x_scale,
        series: series.into_iter().map(|(_, series)| series).collect(),
        key: marks.key(),
        noise: (noise > 0.0).then_some(noise),
        pareto: !light,
        layout: Layout::PAGE,
    })
}

#[cfg(test)]
mod tests {
    use super::super::Drawing as _;
    use super::super::chart::COLORS;
    use super::*;
    use crate::results::record::tests::finished;

    fn rows() -> Vec<Finished> {
        vec![
            finished("nichols", "bilinear", 10.0, 1e-2),
            finished("nichols", "delaunay", 12.0, 1e-3),
            finished("sfvt-gass", "delaunay", 20.0, 2e-3),
            finished("per-pixel", "bilinear", 100.0, 1e-5),
        ]
    }

    fn measured(rows: &[Finished], measure: Measure, against: Against) -> Option<Chart> {
        chart("A hall".to_string(), &rows.iter().collect::<Vec<_>>(), measure, against)
    }

    fn chart_of(against: Against) -> Chart {
        measured(&rows(), Measure::Nmse2, against).unwrap()
    }

    #[test]
    fn perceptual_errors_have_charts_of_the_rows_that_were_measured() {
        let mut rows = rows();
        rows[1].record.grain = None;
        rows[2].record.reference_grain = Some(1e-2);
        for (measure, points, noise, label) in [
            (Measure::FlipP99, 4, None, "FLIP, 99th percentile"),
            (Measure::Grain, 3, Some(1e-2), "grain of the penumbra"),
        ] {
            let chart = measured(&rows, measure, Against::Time).unwrap();
            assert_eq!((chart.series.len(), chart.noise), (points, noise));
            assert!(chart.svg().unwrap().contains(label));
            assert!(chart.series.iter().all(|series| series.points[0].y >= 1e-5f64.sqrt()));
        }
        rows.iter_mut().for_each(|row| row.record.flip_p99 = None);
        assert_eq!(measured(&rows, Measure::FlipP99, Against::Time), None);
        assert_eq!(measured(&[], Measure::Nmse2, Against::Rays), None);
    }

    #[test]
    fn the_front_leaves_out_what_is_beaten() {
        let chart = chart_of(Against::Time);
        let names: Vec<&str> = chart.front().iter().map(|point| point.name.as_str()).collect();
        assert_eq!(
            names,
            ["nichols · bilinear · ratio", "nichols · delaunay · ratio", "per-pixel · bilinear · ratio"]
        );
    }

    #[test]
    fn the_svg_names_everything() {
        for against in [Against::Time, Against::Rays] {
            let svg = chart_of(against).svg().unwrap();
            for words in [
                "A hall",
                "nichols",
                "sfvt-gass",
                "per-pixel (Monte Carlo)",
                "bilinear",
                "delaunay",
                "ratio",
                "noise of",
            ] {
                assert!(svg.contains(words), "{words} is missing");
            }
            // Four rows and nine entries of the key, each a filled polygon.
            assert!(svg.matches("<polygon").count() >= 10);
        }
    }

    #[test]
    fn the_bitmap_shows_text_and_marks() {
        let (width, height, pixels) = chart_of(Against::Time).pixels().unwrap();
        assert_eq!(pixels.len(), (width * height) as usize);
        let blue = |p: &&[u8; 3]| **p == COLORS[0];
        assert!(pixels.iter().filter(blue).count() > 50);
        // The title's row band holds ink.
        let title = &pixels[28 * width as usize..72 * width as usize];
        assert!(title.iter().filter(|p| p[0] < 128).count() > 50);
    }

    #[test]
    fn names_with_dots_stay_whole() {
        let folder = tempfile::tempdir().unwrap();
        chart_of(Against::Rays).write(&folder.path().join("hall-x0.5-rays")).unwrap();
        for name in ["hall-x0.5-rays.svg", "hall-x0.5-rays.png"] {
            assert!(folder.path().join(name).is_file(), "{name} is missing");
        }
    }

    #[test]
    fn colours_tell_backends_apart_where_these_vary_most() {
        let mut rows = rows();
        for (row, name) in rows.iter_mut().zip(["bvh", "beam", "raster4d", "voxel"]) {
            row.record.visibility = name.to_string();
        }
        let chart = measured(&rows, Measure::Nmse2, Against::Time).unwrap();
        assert_eq!(chart.key[1].title, "Colour: backend");
        let colors: std::collections::BTreeSet<[u8; 3]> =
            chart.series.iter().map(|series| series.mark.rgb).collect();
        assert_eq!(colors.len(), 4);
    }

    #[test]
    fn rivals_have_shapes_and_names_of_their_own() {
        let mut rows = rows();
        rows.push(finished("pcss", "pcf", 30.0, 1e-2));
        rows.push(finished("filtered", "svgf", 40.0, 1e-3));
        let chart = measured(&rows, Measure::FlipP99, Against::Time).unwrap();
        let shapes: std::collections::BTreeSet<String> =
            chart.key[0].entries.iter().map(|(mark, _)| format!("{:?}", mark.shape)).collect();
        assert_eq!(shapes.len(), 5);
        let svg = chart.svg().unwrap();
        for name in ["pcss", "filtered", "pcf", "svgf"] {
            assert!(svg.contains(name), "{name} is missing");
        }
    }

    #[test]
    fn sizes_of_light_are_joined() {
        let mut rows = rows();
        let mut larger = rows.clone();
        larger.iter_mut().for_each(|row| row.record.light_scale = 2.0);
        rows.append(&mut larger);
        let chart = measured(&rows, Measure::Nmse, Against::Light).unwrap();
        assert_eq!(chart.series.len(), 4);
        assert!(chart.series.iter().all(|series| series.connected && series.points.len() == 2));
        assert!(chart.front().is_empty() && chart.svg().unwrap().contains("<polyline"));
    }
}
