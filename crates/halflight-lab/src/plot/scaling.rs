//! Charts of growing time.

use indexmap::IndexSet;

use super::chart::{COLORS, Chart, Mark, Point, Series, Shape};
use crate::analysis::scaling::{Growth, PowerLaw};
use crate::experiment::Axis;

/// Returns a chart of the time of the visibility stage against the axis, both logarithmic: a colour a backend, a shape a
/// scene, slopes in the key.
pub fn chart(title: String, lines: &[Growth], axis: Axis) -> Chart {
    let (mut backends, mut scenes) = (IndexSet::new(), IndexSet::new());
    let line = |line: &Growth| {
        let (backend, _) = backends.insert_full(format!("{} {}", line.visibility, line.rest));
        let (scene, _) = scenes.insert_full(line.scene.clone());
        let mark = Mark::filled(Shape::nth(scene), COLORS[backend % COLORS.len()]);
        let name = line.name();
        let points = line.points.iter().map(|&(x, y)| Point::new(x, y, name.clone()));
        (Series::line(mark, points), (mark, format!("{name}: {}", PowerLaw::words(line.law))))
    };
    let (series, entries) = lines.iter().map(line).unzip();
    let labels = [axis.quantity(), "time of the visibility stage, ms"];
    Chart::new(title, labels, series, (format!("Time ~ {}^slope", axis.quantity()), entries))
}

#[cfg(test)]
mod tests {
    use super::super::Drawing as _;
    use super::*;
    use crate::analysis::scaling::{lines, tests::rows};

    #[test]
    fn every_backend_has_its_line_and_its_slope_in_the_key() {
        let lines = lines(&rows(), Axis::Samples);
        let svg = chart("Growth".to_string(), &lines, Axis::Samples).svg().unwrap();
        assert!(svg.contains("raster4d, hall: slope 0.50") && svg.matches("<polyline").count() >= 2);
    }
}
