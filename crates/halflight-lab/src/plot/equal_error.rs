//! Charts of the time at equal error.

use itertools::Itertools as _;

use super::chart::{Chart, Mark, Point, Series};
use crate::analysis::equal_error::{Family, Summary};

/// Returns a chart of mean time against target, for the families that are the fastest of their refiner and backend at some
/// target: shape by refiner, colour by line. Targets are left out for which some scene's reference is too noisy.
pub fn chart(summary: &Summary) -> Chart {
    let told: Vec<usize> =
        (0..summary.targets.len()).filter(|&target| summary.is_told_everywhere(target)).collect();
    let mut best: Vec<&Family> = Vec::new();
    for &target in &told {
        let reached = summary.ranking(target).into_iter().filter(|family| family.mean(target).is_some());
        for family in reached.unique_by(|family| (&family.refiner, &family.visibility)) {
            if !best.contains(&family) {
                best.push(family);
            }
        }
    }
    let line = |(index, family): (usize, &Family)| {
        let mark = Mark { filled: family.shading == "ratio", ..Mark::nth(index) };
        let point =
            |&target: &usize| Some(Point::new(family.mean(target)?, summary.targets[target], family.label()));
        (Series::line(mark, told.iter().filter_map(point)), (mark, family.label()))
    };
    let (series, entries) = best.into_iter().enumerate().map(line).unzip();
    let title = "Time at equal error, geometric mean over scenes";
    let key = "Fastest of each refiner and backend";
    Chart::new(title, ["time of a frame, ms", "NMSE₂ reached"], series, (key, entries))
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
