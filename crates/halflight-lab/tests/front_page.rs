//! Front page of a report: findings, a chart a setting, pictures side by side and magnified.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail their test")]

use std::fs;

use halflight_lab::experiment::Experiment;
use halflight_lab::report;
use halflight_lab::results::{Provenance, WINDOW};
use halflight_lab::run::{Device, Places, run};

const TINY: &str = r#"
title = "Tiny"
description = "The three rows that a front page shows."
front_page = true
size = [128, 96]
repetitions = 1
[reference]
samples = 512
seed = 9
[[scene]]
name = "contact"
[[grid]]
refiners = [{ name = "lattice", target = 1e-4, visible_error = 0.04 }]
upsamplers = ["lattice"]
shadings = ["ratio"]
samples = [64]
[[grid]]
refiners = [{ name = "sfvt-gass" }, { name = "per-pixel" }]
upsamplers = ["rbf-adaptive"]
shadings = ["sampled"]
samples = [16]
"#;

#[test]
fn an_experiment_that_asks_for_it_opens_with_findings_charts_and_pictures() {
    let root = tempfile::tempdir().unwrap();
    let places = Places { out: root.path().join("out"), references: root.path().join("references") };
    let experiment = Experiment::parse(TINY, "tiny.toml").unwrap();
    let provenance = Provenance { threads: 1, program: 1, ..Provenance::default() };
    let outcome = run(&experiment, &places, &Device::Cpu, &provenance, |_| Ok(())).unwrap();
    // The window lies in the picture.
    assert!(outcome.rows.iter().all(|row| row.worst[0] <= 128 - WINDOW[0] && row.worst[1] <= 96 - WINDOW[1]));
    let page = |experiment: &Experiment| {
        report::write(experiment, &outcome, &places.out, "command").unwrap();
        fs::read_to_string(places.out.join("report.html")).unwrap()
    };

    let whole = page(&experiment);
    let front = &whole[whole.find("<section class=\"front\">").unwrap()..whole.find("</section>").unwrap()];
    for words in
        ["At quality good, Halflight's lattice takes", "Koa 2017 as published", "in contact", "Reference"]
    {
        assert!(front.contains(words), "{words} is missing in {front}");
    }
    let files: Vec<&str> =
        front.split("src=\"").skip(1).map(|rest| &rest[..rest.find('"').unwrap()]).collect();
    assert_eq!(files.len(), 1 + 1 + 3, "{files:?}");
    assert_eq!(files[0], "charts/contact-families.png");
    for file in files {
        assert!(places.out.join(file).is_file(), "{file} is missing");
    }
    // Nothing but title and style stands before it.
    assert!(whole.find("The three rows").unwrap() > whole.find("</section>").unwrap());

    let plain = page(&Experiment { front_page: false, ..experiment.clone() });
    assert!(!plain.contains("class=\"front\"") && !plain.contains("At quality good"));
}
