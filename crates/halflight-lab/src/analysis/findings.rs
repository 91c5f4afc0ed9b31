//! Findings of an experiment in plain words: who reaches the error of the lattice's qualities first, and where the lattice loses.

use halflight_cpu::refine::Quality;
use indexmap::IndexMap;
use itertools::Itertools as _;

use super::Measure;
use super::equal_error::geometric_mean;
use super::families::{Family, families, lattice_at, published, reach};
use super::format::{duration, error};
use crate::results::Finished;

/// Factor below which two times count as equal: the scatter of medians between runs.
const TIE: f64 = 1.05;

/// Errors that families are compared at, those that are seen first.
const MEASURES: [Measure; 3] = [Measure::FlipP99, Measure::Grain, Measure::Nmse2];

/// Rows of a setting with its name.
pub struct Scene<'a> {
    /// Name for people.
    pub name: &'a str,
    /// Rows.
    pub rows: Vec<&'a Finished>,
}

/// Family against the lattice in a scene at equal error.
struct Verdict<'a> {
    scene: &'a str,
    family: Family,
    /// Time of the family in times of the lattice's; `None` where it never reaches the error.
    factor: Option<f64>,
}

/// Returns the findings, a sentence each, the last one on where the lattice loses; none without a row of the lattice at
/// quality `good`.
pub fn sentences(scenes: &[Scene]) -> Vec<String> {
    let good = scenes.iter().filter_map(|scene| Some((scene.name, lattice_at(&scene.rows, Quality::Good)?)));
    let times = good.map(|(name, row)| format!("{} in {name}", duration(row.record.total_ms))).collect_vec();
    if times.is_empty() {
        return Vec::new();
    }
    let mut sentences = vec![format!("At quality good, Halflight's lattice takes {}.", listed(&times))];
    sentences.extend(against_published(scenes));
    sentences.extend(equal(scenes));
    sentences.push(losses(scenes));
    sentences
}

/// Compares the paper's method as published with the lattice at quality `good`: times and errors.
fn against_published(scenes: &[Scene]) -> Option<String> {
    let rows = scenes.iter().map(|scene| &scene.rows);
    let pairs = rows.filter_map(|rows| Some((published(rows)?, lattice_at(rows, Quality::Good)?)));
    let pairs: Vec<(&Finished, &Finished)> = pairs.collect();
    let mean = |of: &dyn Fn(&Finished) -> Option<f64>| {
        let ratios = pairs.iter().map(|(theirs, ours)| Some(of(theirs)? / of(ours)?));
        geometric_mean(&ratios.collect::<Option<Vec<f64>>>()?)
    };
    let time = mean(&|row| Some(row.record.total_ms))?;
    let error = |measure: Measure| {
        Some(format!("{} times the {}", figure(mean(&|row| measure.of(row))?), measure.words()))
    };
    let errors = MEASURES.into_iter().filter_map(error).collect_vec();
    let means = if pairs.len() > 1 { " (geometric means)" } else { "" };
    Some(format!(
        "Koa 2017 as published (sfvt-gass with rbf-adaptive) takes {} times as long and has {}{means}.",
        figure(time),
        listed(&errors)
    ))
}

/// Returns all families against the lattice at the error of a quality.
fn verdicts<'a>(scenes: &[Scene<'a>], quality: Quality, measure: Measure) -> Vec<Verdict<'a>> {
    let mut verdicts = Vec::new();
    for Scene { name, rows } in scenes {
        let Some(error) = lattice_at(rows, quality).and_then(|row| measure.of(row)) else { continue };
        let Some(ours) = reach(rows, &Family::Lattice, measure, error) else { continue };
        for family in families(rows).into_iter().filter(|family| *family != Family::Lattice) {
            let factor = reach(rows, &family, measure, error).map(|theirs| theirs / ours);
            verdicts.push(Verdict { scene: name, family, factor });
        }
    }
    verdicts
}

/// Returns how long every family takes to reach the errors of quality `good`, in times of the lattice's time: a sentence for
/// each that reaches one, and one for all others.
fn equal(scenes: &[Scene]) -> Vec<String> {
    let verdicts = MEASURES.map(|measure| (measure, verdicts(scenes, Quality::Good, measure)));
    let all = || verdicts.iter().flat_map(|(_, verdicts)| verdicts);
    let (mut sentences, mut never) = (Vec::new(), Vec::new());
    for family in all().map(|verdict| &verdict.family).unique_by(|family| family.name()) {
        let told = verdicts.iter().map(|(measure, verdicts)| {
            let own = verdicts.iter().filter(|verdict| verdict.family == *family).collect_vec();
            format!("the same {} {}", measure.words(), times(&own))
        });
        if all().any(|verdict| verdict.family == *family && verdict.factor.is_some()) {
            sentences.push(format!("With {} {}.", family.name(), listed(&told.collect_vec())));
        } else {
            never.push(family.name().to_string());
        }
    }
    if !never.is_empty() {
        sentences.push(format!("With {} none of these is reached in any scene.", listed(&never)));
    }
    sentences
}

/// Returns the mean of a family's factors with those of the scenes.
fn times(verdicts: &[&Verdict]) -> String {
    let factors: Vec<f64> = verdicts.iter().filter_map(|verdict| verdict.factor).collect();
    let Some(mean) = geometric_mean(&factors) else {
        return "is never reached".to_string();
    };
    let each = verdicts.iter().map(|Verdict { scene, factor, .. }| match factor {
        Some(factor) => format!("{scene} {}", figure(*factor)),
        None => format!("{scene} never"),
    });
    format!("takes {} times as long ({})", figure(mean), each.collect_vec().join(", "))
}

/// Names every family, error, quality and scene at which a family is there before the lattice.
fn losses(scenes: &[Scene]) -> String {
    let mut lost: IndexMap<(String, &str), Vec<String>> = IndexMap::new();
    for (measure, quality) in itertools::iproduct!(MEASURES, Quality::ALL) {
        let mut leads: IndexMap<String, Vec<String>> = IndexMap::new();
        for Verdict { scene, family, factor } in verdicts(scenes, quality, measure) {
            if let Some(lead) = factor.map(|factor| 1.0 / factor).filter(|lead| *lead > TIE) {
                leads.entry(family.name().to_string()).or_default().push(format!("{scene} {}", figure(lead)));
            }
        }
        for (family, leads) in leads {
            let when = format!("at {quality} ({})", leads.join(", "));
            lost.entry((family, measure.words())).or_default().push(when);
        }
    }
    if lost.is_empty() {
        return "At no quality is another family faster to the same error.".to_string();
    }
    let lost = lost
        .into_iter()
        .map(|((family, measure), when)| format!("to {family} by {measure} {}", listed(&when)));
    format!("The lattice loses, by the factors in brackets, {}.", lost.collect_vec().join("; "))
}

/// Returns a factor with two digits.
fn figure(factor: f64) -> String {
    if factor < 9.95 { format!("{factor:.1}") } else { format!("{factor:.0}") }
}

/// Returns a list in words: "a, b and c".
fn listed(items: &[String]) -> String {
    match items {
        [first @ .., last] if !first.is_empty() => format!("{} and {last}", first.join(", ")),
        _ => items.concat(),
    }
}

/// Returns time and visible errors of a row, for the caption of its picture.
pub fn caption(row: &Finished) -> String {
    let mut words = duration(row.record.total_ms);
    for measure in [Measure::FlipP99, Measure::Grain] {
        if let Some(value) = measure.of(row) {
            words += &format!(", {} {}", measure.words(), error(Some(value)));
        }
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::record::tests::finished;

    /// A row of which ꟻLIP is the root of `error`, and grain twice that.
    fn row(refiner: &str, parameters: &str, time: f64, error: f64) -> Finished {
        let upsampler = if refiner == "sfvt-gass" { "rbf-adaptive" } else { "lattice" };
        let mut row = finished(refiner, upsampler, time, error);
        row.record.parameters = parameters.to_string();
        if refiner == "sfvt-gass" {
            row.record.shading = "sampled".to_string();
        }
        row
    }

    const GOOD: &str = "target=0.0001;visible_error=0.04";

    fn told(hall: &[Finished], tree: &[Finished]) -> String {
        let scenes =
            [("hall", hall), ("tree", tree)].map(|(name, rows)| Scene { name, rows: rows.iter().collect() });
        sentences(&scenes).join("\n")
    }

    #[test]
    fn they_say_who_is_as_accurate_and_how_much_slower() {
        let rows = [
            row("lattice", GOOD, 10.0, 1e-4),
            row("sfvt-gass", "", 20.0, 9e-4),
            row("per-pixel", "", 5.0, 4e-4),
            row("per-pixel", "", 20.0, 1e-4),
        ];
        let text = told(&rows, &rows[..2]);
        for words in [
            "At quality good, Halflight's lattice takes 10 ms in hall and 10 ms in tree.",
            "takes 2.0 times as long and has 3.0 times the ꟻLIP, 3.0 times the grain and 9.0 times the NMSE₂ (geometric means).",
            "With per-pixel Monte Carlo the same ꟻLIP takes 2.0 times as long (hall 2.0), the same grain takes 2.0 times as long \
             (hall 2.0) and the same NMSE₂ takes 2.0 times as long (hall 2.0).",
            "With papers' refiners none of these is reached in any scene.",
            "At no quality is another family faster to the same error.",
        ] {
            assert!(text.contains(words), "{words} is missing in\n{text}");
        }
    }

    #[test]
    fn they_name_where_the_lattice_loses() {
        let slow =
            [row("lattice", GOOD, 40.0, 1e-4), row("per-pixel", "", 20.0, 1e-4), row("pcss", "", 10.0, 1e-4)];
        let quick =
            [row("lattice", GOOD, 40.0, 1e-4), row("per-pixel", "", 39.0, 1e-4), row("pcss", "", 1.0, 1e-2)];
        let text = told(&slow, &quick);
        // Two and a half percent are no loss.
        for words in [
            "With per-pixel Monte Carlo the same ꟻLIP takes 0.7 times as long (hall 0.5, tree 1.0)",
            "With PCSS the same ꟻLIP takes 0.2 times as long (hall 0.2, tree never)",
            "The lattice loses, by the factors in brackets, to per-pixel Monte Carlo by ꟻLIP at good (hall 2.0); to PCSS by ꟻLIP at good \
             (hall 4.0); to per-pixel Monte Carlo by grain",
        ] {
            assert!(text.contains(words), "{words} is missing in\n{text}");
        }
    }

    #[test]
    fn without_the_quality_there_is_nothing_to_say() {
        assert_eq!(told(&[row("lattice", "", 10.0, 1e-4)], &[]), "");
    }
}
