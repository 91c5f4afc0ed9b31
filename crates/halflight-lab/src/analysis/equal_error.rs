//! Time that each method takes to reach the same error.
//!
//! A family is every row that differs in nothing but its knobs: constants, and number and placement of light samples. Its
//! own front of time and error says how long it takes to reach an error; a geometric mean over scenes makes one figure of
//! it, in which a factor counts the same in every scene.

use itertools::Itertools as _;

use super::format::{error, time};
use super::pareto;
use crate::results::{Finished, Line, Record, Table};

/// A scene is left out of a target that is less than this many times its reference's own error: a measured error is the
/// true one plus the reference's, a quarter of the target at this limit.
const MARGIN: f64 = 4.0;

/// Returns the time at which points `(time, error)` reach a target: on their front, between two of its points as a power law,
/// and never before its first. `None` where no point reaches it.
pub fn time_at(points: &[(f64, f64)], target: f64) -> Option<f64> {
    let front = pareto::front(points);
    let reached = front.iter().position(|&index| points[index].1 <= target)?;
    let (t1, e1) = points[front[reached]];
    let Some(before) = reached.checked_sub(1) else { return Some(t1) };
    let (t0, e0) = points[front[before]];
    // An error of zero has no logarithm: it is as far as one can go.
    let share = if e1 > 0.0 { (e0 / target).ln() / (e0 / e1).ln() } else { 1.0 };
    Some(t0 * (t1 / t0).powf(share))
}

/// Returns the geometric mean; `None` of no values.
pub fn geometric_mean(values: &[f64]) -> Option<f64> {
    let sum: f64 = values.iter().map(|value| value.ln()).sum();
    (!values.is_empty()).then(|| (sum / values.len() as f64).exp())
}

/// Rows that differ in their knobs alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Family {
    /// Refiner.
    pub refiner: String,
    /// Visibility backend.
    pub visibility: String,
    /// Upsampler; empty where every pixel is a fragment.
    pub upsampler: String,
    /// Shading.
    pub shading: String,
    /// Time in ms at which the family reaches each target, scene by scene.
    pub times: Vec<Vec<Reached>>,
}

/// Time at which a family reaches a target in a scene, or the reason why there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reached {
    /// Milliseconds.
    In(f64),
    /// No row of the family does.
    Never,
    /// The family has no row there.
    NotRun,
    /// The reference is too noisy to tell.
    Untold,
}

impl Family {
    /// Returns the family's name.
    pub fn label(&self) -> String {
        let parts = [&self.refiner, &self.upsampler, &self.shading, &self.visibility];
        parts.into_iter().filter(|part| !part.is_empty()).join(" · ")
    }

    /// Returns the geometric mean over all scenes that can tell; `None` where the target is not reached in one of them.
    pub fn mean(&self, target: usize) -> Option<f64> {
        let told = self.times[target].iter().filter(|reached| **reached != Reached::Untold);
        let times = told.map(|reached| if let Reached::In(ms) = reached { Some(*ms) } else { None });
        geometric_mean(&times.collect::<Option<Vec<f64>>>()?)
    }
}

/// Families against targets.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Targets, NMSE₂.
    pub targets: Vec<f64>,
    /// Slugs of the settings.
    pub scenes: Vec<String>,
    /// Families in the order of their first rows.
    pub families: Vec<Family>,
}

/// Returns all families, with scenes in the order in which they occur.
pub fn summary(rows: &[Finished], targets: &[f64]) -> Summary {
    let scenes: Vec<String> = rows.iter().map(|row| row.setting.clone()).unique().collect();
    let reached = |of: &[&str; 4], scene: &str, target: f64| {
        let here = || rows.iter().filter(|row| row.setting == scene);
        let noise = here().map(|row| row.record.reference_noise).fold(0.0, f64::max);
        let own = here().filter(|row| key(&row.record) == *of);
        let points: Vec<(f64, f64)> = own.map(|row| (row.record.total_ms, row.record.nmse2)).collect();
        match time_at(&points, target) {
            _ if noise * MARGIN > target => Reached::Untold,
            _ if points.is_empty() => Reached::NotRun,
            None => Reached::Never,
            Some(ms) => Reached::In(ms),
        }
    };
    let family = |key: &[&str; 4]| {
        let [refiner, visibility, upsampler, shading] = key.map(str::to_string);
        let at = |target: f64| scenes.iter().map(|scene| reached(key, scene, target)).collect();
        let times = targets.iter().map(|&target| at(target)).collect();
        Family { refiner, visibility, upsampler, shading, times }
    };
    let families = rows.iter().map(|row| key(&row.record)).unique().map(|key| family(&key)).collect();
    Summary { targets: targets.to_vec(), families, scenes }
}

/// Returns the choices that tell families apart.
fn key(record: &Record) -> [&str; 4] {
    let upsampler = if record.refiner == "per-pixel" { "" } else { &record.upsampler };
    [&record.refiner, &record.visibility, upsampler, &record.shading]
}

impl Summary {
    /// Returns the families by mean time, the fastest first; then those that do not get there in every scene, by the number of scenes
    /// in which they do.
    pub fn ranking(&self, target: usize) -> Vec<&Family> {
        let mut families: Vec<&Family> = self.families.iter().collect();
        let reached = |family: &Family| {
            family.times[target].iter().filter(|reached| matches!(reached, Reached::In(_))).count()
        };
        families.sort_by(|a, b| {
            let mean = |family: &Family| family.mean(target).unwrap_or(f64::INFINITY);
            mean(a).total_cmp(&mean(b)).then(reached(b).cmp(&reached(a)))
        });
        families
    }

    /// Returns a table with a line for each target and family.
    pub fn table(&self) -> Table {
        let stages = ["NMSE₂", "refiner", "visibility", "upsampler", "shading"];
        let mut table = Table::new(stages, []);
        table.columns.extend(["geometric mean, ms", "times the fastest"].map(str::to_string));
        table.columns.extend(self.scenes.iter().map(|scene| format!("{scene}, ms")));
        for (index, &target) in self.targets.iter().enumerate() {
            let ranking = self.ranking(index);
            let fastest = ranking.first().and_then(|family| family.mean(index));
            for family in ranking {
                let mean = family.mean(index);
                let factor = mean.zip(fastest).map(|(mean, fastest)| mean / fastest);
                let mut cells = vec![
                    error(Some(target)),
                    family.refiner.clone(),
                    family.visibility.clone(),
                    family.upsampler.clone(),
                    family.shading.clone(),
                    mean.map_or("not everywhere".to_string(), |mean| time(Some(mean))),
                    factor.map_or(String::new(), |factor| format!("{factor:.2}")),
                ];
                cells.extend(family.times[index].iter().map(|reached| match reached {
                    Reached::In(ms) => time(Some(*ms)),
                    Reached::Never => "never".to_string(),
                    Reached::NotRun => "not run".to_string(),
                    Reached::Untold => "reference too noisy".to_string(),
                }));
                table.lines.push(Line { from_paper: false, cells });
            }
        }
        table
    }

    /// Returns whether all scenes can tell: means over fewer of them are no points of the same line.
    pub fn is_told_everywhere(&self, target: usize) -> bool {
        self.families.iter().all(|family| !family.times[target].contains(&Reached::Untold))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::results::record::tests::finished;

    #[test]
    fn times_are_read_off_the_front_as_power_laws() {
        // Error falls with the square of the time; a slower and worse point must not count.
        let points = [(10.0, 1e-2), (100.0, 1e-4), (50.0, 5e-2), (1000.0, 1e-6)];
        let at = |target| time_at(&points, target);
        // Exact powers of ten but for rounding of logarithms.
        assert!((at(1e-3).unwrap() - 10f64.powf(1.5)).abs() < 1e-9);
        assert!((at(1e-5).unwrap() - 10f64.powf(2.5)).abs() < 1e-9);
        assert_eq!((at(1e-4), at(1e-6)), (Some(100.0), Some(1000.0)));
        // No faster than the fastest, and no more accurate than the most accurate.
        assert_eq!((at(0.5), at(1e-7), time_at(&[], 1.0)), (Some(10.0), None, None));
    }

    #[test]
    fn an_exact_point_is_as_far_as_one_can_go() {
        assert_eq!(time_at(&[(1.0, 1e-2), (8.0, 0.0)], 1e-4), Some(8.0));
    }

    #[test]
    fn a_factor_counts_the_same_everywhere() {
        assert!((geometric_mean(&[1.0, 100.0]).unwrap() - 10.0).abs() < 1e-12);
        let halved = geometric_mean(&[4.0, 50.0]).unwrap();
        assert!((geometric_mean(&[8.0, 100.0]).unwrap() / halved - 2.0).abs() < 1e-12);
        assert_eq!(geometric_mean(&[]), None);
    }

    fn row(scene: &str, refiner: &str, samples: u32, time: f64, error: f64) -> Finished {
        let mut row = finished(refiner, "bilinear", time, error);
        (row.setting, row.record.samples) = (scene.to_string(), samples);
        row
    }

    pub(crate) fn rows() -> Vec<Finished> {
        vec![
            row("hall", "per-pixel", 4, 10.0, 1e-3),
            row("hall", "per-pixel", 16, 40.0, 1e-4),
            row("hall", "nichols", 64, 5.0, 9e-4),
            row("tree", "per-pixel", 4, 100.0, 1e-3),
            row("tree", "nichols", 64, 20.0, 2e-3),
        ]
    }

    #[test]
    fn families_that_do_not_reach_a_target_say_so() {
        let summary = summary(&rows(), &[1e-3, 1e-4]);
        assert_eq!(summary.families.len(), 2);
        let (per_pixel, nichols) = (&summary.families[0], &summary.families[1]);
        assert_eq!(per_pixel.label(), "per-pixel · ratio · bvh");
        assert!((per_pixel.mean(0).unwrap() - 1000f64.sqrt()).abs() < 1e-9);
        assert_eq!((per_pixel.mean(1), nichols.mean(0)), (None, None));
        let table = summary.table();
        assert_eq!(table.columns[7..], ["hall, ms", "tree, ms"]);
        assert_eq!(table.lines[0].cells[5..], ["31.6", "1.00", "10.0", "100.0"]);
        assert_eq!(table.lines[1].cells[5..], ["not everywhere", "", "5.00", "never"]);
    }

    #[test]
    fn noisy_references_tell_nothing() {
        let mut rows = rows();
        rows.iter_mut().filter(|row| row.setting == "tree").for_each(|row| row.record.reference_noise = 3e-4);
        let summary = summary(&rows, &[1e-3]);
        assert_eq!(summary.families[1].times, [[Reached::In(5.0), Reached::Untold]]);
        // exp(ln 5), rounded.
        assert!((summary.families[1].mean(0).unwrap() - 5.0).abs() < 1e-12);
    }

    #[test]
    fn a_family_without_rows_in_a_scene_has_no_mean() {
        let summary = summary(&rows()[..4], &[1e-3]);
        assert_eq!(summary.families[1].times, [[Reached::In(5.0), Reached::NotRun]]);
        assert_eq!(summary.families[1].mean(0), None);
    }
}
