//! Charts of how time grows.

use super::chart::{Chart, KeyGroup, Mark, Point, Scale, Series, Shape};
use super::marks::COLORS;
use crate::analysis::scaling::{Growth, PowerLaw};
use crate::experiment::Axis;

/// Time of the visibility stage against the axis, both logarithmic: a colour a backend, a shape a scene, slopes in the key.
pub fn chart(title: String, lines: &[Growth], axis: Axis) -> Chart {
    let place = |names: &mut Vec<String>, name: &str| {
        names.iter().position(|known| known == name).unwrap_or_else(|| {
            names.push(name.to_string());
            names.len() - 1
        })
    };
    let (mut backends, mut scenes) = (Vec::new(), Vec::new());
    let (mut series, mut entries) = (Vec::new(), Vec::new());
    for line in lines {
        let backend = place(&mut backends, &format!("{} {}", line.visibility, line.rest));
        let mark = Mark {
            shape: Shape::ALL[place(&mut scenes, &line.scene) % Shape::ALL.len()],
            rgb: COLORS[backend % COLORS.len()],
            filled: true,
        };
        let name = line.name();
        entries.push((mark, format!("{name}: {}", PowerLaw::words(line.law))));
        let points = line.points.iter().map(|&(x, y)| Point { x, y, name: name.clone(), note: None });
        series.push(Series { mark, points: points.collect(), connected: true });
    }
    Chart {
        title,
        x_label: axis.quantity().to_string(),
        y_label: "time of the visibility stage, ms".to_string(),
        x_scale: Scale::Log,
        series,
        key: vec![KeyGroup { title: format!("Time ~ {}^slope", axis.quantity()), entries }],
        noise: None,
        pareto: false,
    }
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
