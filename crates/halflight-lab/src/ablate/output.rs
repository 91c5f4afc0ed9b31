//! The files that an experiment ends in.

use std::io::Write;

use halflight_metrics::write_atomically;
use itertools::iproduct;

use super::chart::{Against, Chart, errors};
use super::experiment::{Experiment, Scaling};
use super::plan::{scene_label, slug};
use super::record::{Finished, write_csv};
use super::report::{self, Figure};
use super::run::{Outcome, Places};
use super::{AblateError, equal_error, equal_time, error, paper, scaling, sweep};

/// Writes `results.csv`, the tables that the experiment asks for (`paper.csv`, `equal-time.csv`, `summary.csv`, `slopes.csv`), the charts
/// and `report.html`. `command` is what the report says it was made by.
///
/// # Errors
/// A chart cannot be drawn or a file not be written.
pub fn write(
    experiment: &Experiment,
    outcome: &Outcome,
    places: &Places,
    command: &str,
) -> Result<(), AblateError> {
    write_csv(&places.out.join("results.csv"), outcome.rows.iter().map(|row| &row.record))?;
    if let Some(paper) = &experiment.paper
        && !paper.rows.is_empty()
    {
        paper::table(paper, &outcome.rows).write_csv(&places.out.join("paper.csv"))?;
    }
    if let Some(visibility) = &experiment.equal_time {
        equal_time::table(&outcome.rows, visibility).write_csv(&places.out.join("equal-time.csv"))?;
    }
    if !experiment.equal_error.is_empty() {
        let summary = equal_error::summary(&outcome.rows, &experiment.equal_error);
        summary.table().write_csv(&places.out.join("summary.csv"))?;
    }
    if let Some(Scaling { axis }) = experiment.scaling {
        let lines = scaling::lines(&outcome.rows, axis);
        scaling::table(&lines, axis).write_csv(&places.out.join("slopes.csv"))?;
    }
    let figures = charts(experiment, outcome, places)?;
    let html = report::html(experiment, outcome, &figures, command)?;
    write_atomically(&places.out.join("report.html"), |file| file.write_all(html.as_bytes()))?;
    Ok(())
}

/// Draws the charts and returns where they are.
fn charts(experiment: &Experiment, outcome: &Outcome, places: &Places) -> Result<Vec<Figure>, AblateError> {
    let folder = places.out.join("charts");
    std::fs::create_dir_all(&folder).map_err(error::at(&folder))?;
    let mut figures = Vec::new();
    let mut draw = |slug: String, chart: Chart, settings: Vec<String>| {
        chart.write(&folder.join(&slug))?;
        figures.push(Figure { path: format!("charts/{slug}"), title: chart.title, settings });
        Ok::<(), AblateError>(())
    };
    if let Some(Scaling { axis }) = experiment.scaling {
        let lines = scaling::lines(&outcome.rows, axis);
        let title = format!("Visibility against {}", axis.quantity());
        draw("scaling".to_string(), scaling::chart(title, &lines, axis), Vec::new())?;
    }
    if !experiment.equal_error.is_empty() {
        let summary = equal_error::summary(&outcome.rows, &experiment.equal_error);
        draw("summary".to_string(), summary.chart(), Vec::new())?;
    }
    for setting in &outcome.settings {
        let rows: Vec<&Finished> = outcome.rows.iter().filter(|row| row.setting == setting.slug).collect();
        if rows.is_empty() {
            continue;
        }
        let (name, here) = (sized(&setting.label, experiment), vec![setting.slug.clone()]);
        if experiment.scaling.is_none() {
            for (against, words) in [(Against::Time, "time"), (Against::Rays, "rays")] {
                let chart = errors(format!("{name}: error against {words}"), &rows, against);
                draw(format!("{}-{words}", setting.slug), chart, here.clone())?;
            }
        }
        if let Some(constant) = &experiment.sweep
            && let Some(chart) = sweep::chart(format!("{name}: error against {constant}"), &rows, constant)
        {
            draw(format!("{}-{}", setting.slug, slug(constant)), chart, here)?;
        }
    }
    if experiment.light_scales.len() > 1 {
        for ((index, choice), &size) in iproduct!(experiment.scenes.iter().enumerate(), &experiment.sizes) {
            let mine =
                outcome.settings.iter().filter(|setting| (setting.scene, setting.size) == (index, size));
            let slugs: Vec<String> = mine.map(|setting| setting.slug.clone()).collect();
            let rows: Vec<&Finished> =
                outcome.rows.iter().filter(|row| slugs.contains(&row.setting)).collect();
            if !rows.is_empty() {
                let [width, height] = size;
                let name = format!("{}, {width} × {height}", scene_label(choice));
                let chart =
                    errors(format!("{name}: error against the size of the light"), &rows, Against::Light);
                draw(format!("{}-light", slugs[0]), chart, slugs[..1].to_vec())?;
            }
        }
    }
    Ok(figures)
}

/// A setting's label with the size of the image, which labels say only where there are several.
fn sized(label: &str, experiment: &Experiment) -> String {
    match experiment.sizes.as_slice() {
        [[width, height]] => format!("{label}, {width} × {height}"),
        _ => label.to_string(),
    }
}
