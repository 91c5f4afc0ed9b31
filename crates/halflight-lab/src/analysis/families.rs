//! Families of rows: methods that a reader knows by one name, whatever their constants.

use halflight_cpu::refine::Quality;

use super::Measure;
use super::equal_error::time_at;
use crate::experiment::quality;
use crate::results::{Finished, Record};

/// Method that rows belong to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Family {
    /// Lattice refiner with exact visibility: Halflight's own.
    Lattice,
    /// Refiners of papers, `nichols` and `sfvt-gass`, with exact visibility and any upsampler.
    Papers,
    /// Every pixel with its own samples and exact visibility: Monte Carlo.
    PerPixel,
    /// Voxel marching under any refiner.
    Voxel,
    /// Rival of this name, from outside the pipeline.
    Rival(String),
}

impl Family {
    /// Returns the family of a row.
    pub fn of(record: &Record) -> Self {
        match (record.refiner.as_str(), record.visibility.as_str()) {
            (_, "voxel") => Self::Voxel,
            ("lattice", _) => Self::Lattice,
            ("nichols" | "sfvt-gass", _) => Self::Papers,
            ("per-pixel", _) => Self::PerPixel,
            (rival, _) => Self::Rival(rival.to_string()),
        }
    }

    /// Returns the name for people.
    pub fn name(&self) -> &str {
        match self {
            Self::Lattice => "Halflight's lattice",
            Self::Papers => "papers' refiners",
            Self::PerPixel => "per-pixel Monte Carlo",
            Self::Voxel => "voxel marching",
            Self::Rival(name) if name == "pcss" => "PCSS",
            Self::Rival(name) if name == "filtered" => "filtered Monte Carlo",
            Self::Rival(name) => name,
        }
    }
}

/// Returns the families that rows belong to, the lattice first, rivals last and in the order of their rows.
pub fn families(rows: &[&Finished]) -> Vec<Family> {
    let mut found = vec![Family::Lattice, Family::Papers, Family::PerPixel, Family::Voxel];
    found.retain(|family| rows.iter().any(|row| Family::of(&row.record) == *family));
    for row in rows {
        let family = Family::of(&row.record);
        if !found.contains(&family) {
            found.push(family);
        }
    }
    found
}

/// Returns the rows of a family.
pub fn members<'a>(rows: &[&'a Finished], family: &Family) -> Vec<&'a Finished> {
    rows.iter().copied().filter(|row| Family::of(&row.record) == *family).collect()
}

/// Returns times in ms and errors of the rows for which the error was measured.
pub fn points(rows: &[&Finished], measure: Measure) -> Vec<(f64, f64)> {
    rows.iter().filter_map(|row| Some((row.record.total_ms, measure.of(row)?))).collect()
}

/// Returns the time at which a family reaches an error; `None` where it never does.
pub fn reach(rows: &[&Finished], family: &Family, measure: Measure, error: f64) -> Option<f64> {
    time_at(&points(&members(rows, family), measure), error)
}

/// Returns the fastest row of the lattice with its own upsampler at a quality.
pub fn lattice_at<'a>(rows: &[&'a Finished], wanted: Quality) -> Option<&'a Finished> {
    let own = |row: &&Finished| {
        let Record { refiner, upsampler, shading, visibility, parameters, .. } = &row.record;
        [refiner, upsampler, shading] == ["lattice", "lattice", "ratio"]
            && visibility != "voxel"
            && quality(parameters) == Some(wanted)
    };
    fastest(rows.iter().copied().filter(own))
}

/// Returns the fastest row of Koa, Johan and Sourin (2017) as published: their refiner, upsampler and shading with exact
/// visibility.
pub fn published<'a>(rows: &[&'a Finished]) -> Option<&'a Finished> {
    let own = |row: &&Finished| {
        let Record { refiner, upsampler, shading, visibility, parameters, .. } = &row.record;
        [refiner, upsampler, shading] == ["sfvt-gass", "rbf-adaptive", "sampled"]
            && visibility != "voxel"
            && parameters.is_empty()
    };
    fastest(rows.iter().copied().filter(own))
}

fn fastest<'a>(rows: impl Iterator<Item = &'a Finished>) -> Option<&'a Finished> {
    rows.min_by(|a, b| a.record.total_ms.total_cmp(&b.record.total_ms))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::record::tests::finished;

    #[test]
    fn rows_go_to_the_family_of_their_stages() {
        let mut rows: Vec<Finished> = ["pcss", "per-pixel", "sfvt-gass", "lattice", "nichols"]
            .map(|name| finished(name, "lattice", 1.0, 0.1))
            .into();
        rows[4].record.visibility = "voxel".to_string();
        let rows: Vec<&Finished> = rows.iter().collect();
        let names: Vec<String> = families(&rows).iter().map(|family| family.name().to_string()).collect();
        assert_eq!(
            names,
            ["Halflight's lattice", "papers' refiners", "per-pixel Monte Carlo", "voxel marching", "PCSS"]
        );
        assert_eq!(members(&rows, &Family::Papers)[0].record.refiner, "sfvt-gass");
    }

    #[test]
    fn the_rows_to_show_are_found_by_their_stages() {
        let mut rows = vec![
            finished("lattice", "lattice", 5.0, 1e-4),
            finished("lattice", "lattice", 4.0, 1e-4),
            finished("sfvt-gass", "rbf-adaptive", 3.0, 1e-3),
        ];
        for row in &mut rows[..2] {
            row.record.parameters = "target=0.0001;visible_error=0.04".to_string();
        }
        let found = |rows: &[Finished]| {
            let rows: Vec<&Finished> = rows.iter().collect();
            let time = |row: Option<&Finished>| row.map(|row| row.record.total_ms);
            (time(lattice_at(&rows, Quality::Good)), time(published(&rows)))
        };
        assert_eq!(found(&rows), (Some(4.0), None));
        rows[1].record.upsampler = "bilinear".to_string();
        rows[2].record.shading = "sampled".to_string();
        assert_eq!(found(&rows), (Some(5.0), Some(3.0)));
    }
}
