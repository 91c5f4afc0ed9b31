//! Chart of the time at equal error.

use super::chart::{Chart, KeyGroup, Mark, Point, Scale, Series, Shape};
use super::marks::COLORS;
use crate::analysis::equal_error::{Family, Summary};

/// Mean time against target, for the families that are the fastest of their refiner and backend at some target. Shape
/// by refiner, colour by line. Targets are left out for which some scene's reference is too noisy.
pub fn chart(summary: &Summary) -> Chart {
    let told: Vec<usize> =
        (0..summary.targets.len()).filter(|&target| summary.is_told_everywhere(target)).collect();
    let mut best: Vec<&Family> = Vec::new();
    for &target in &told {
        let mut seen: Vec<[&str; 2]> = Vec::new();
        for family in summary.ranking(target).into_iter().filter(|family| family.mean(target).is_some()) {
            let group = [family.refiner.as_str(), family.visibility.as_str()];
            if !seen.contains(&group) {
                seen.push(group);
                if !best.contains(&family) {
                    best.push(family);
                }
            }
        }
    }
    let (mut series, mut entries) = (Vec::new(), Vec::new());
    for (index, family) in best.into_iter().enumerate() {
        let mark = Mark {
            shape: Shape::ALL[index / COLORS.len() % Shape::ALL.len()],
            rgb: COLORS[index % COLORS.len()],
            filled: family.shading == "ratio",
        };
        let point = |&target: &usize| {
            let (x, y) = (family.mean(target)?, summary.targets[target]);
            Some(Point { x, y, name: family.label(), note: None })
        };
        let points = told.iter().filter_map(point).collect();
        entries.push((mark, family.label()));
        series.push(Series { mark, points, connected: true });
    }
    Chart {
        title: "Time at equal error, geometric mean over scenes".to_string(),
        x_label: "time of a frame, ms".to_string(),
        y_label: "NMSE₂ reached".to_string(),
        x_scale: Scale::Log,
        series,
        key: vec![KeyGroup { title: "Fastest of each refiner and backend".to_string(), entries }],
        noise: None,
        pareto: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::equal_error::{summary, tests::rows};

    #[test]
    fn lines_are_of_families_that_get_there_in_every_scene() {
        assert_eq!(chart(&summary(&rows(), &[1e-3, 1e-4])).series.len(), 1);
        let mut rows = rows();
        rows.iter_mut().filter(|row| row.setting == "tree").for_each(|row| row.record.reference_noise = 3e-4);
        // A mean over other scenes is no point of the line.
        assert!(chart(&summary(&rows, &[1e-3])).series.is_empty());
    }
}
