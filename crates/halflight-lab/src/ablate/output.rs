//! The files that an experiment ends in.

use std::io::Write;

use halflight_metrics::write_atomically;

use super::chart::{Against, errors};
use super::experiment::Experiment;
use super::paper;
use super::record::{Finished, write_csv};
use super::report::{self, Figure};
use super::run::{Outcome, Places};
use super::{AblateError, error};

/// Writes `results.csv`, `paper.csv`, the charts and `report.html`. `command` is what the report says it was made by.
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
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(paper::COLUMNS)?;
        for line in paper::lines(paper, &outcome.rows) {
            writer.write_record(line.cells)?;
        }
        let bytes = writer.into_inner().map_err(|fault| csv::Error::from(fault.into_error()))?;
        write_atomically(&places.out.join("paper.csv"), |file| file.write_all(&bytes))?;
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
    let mut draw = |slug: String, title: String, rows: &[&Finished], against, settings: Vec<String>| {
        errors(title.clone(), rows, against).write(&folder.join(&slug))?;
        figures.push(Figure { path: format!("charts/{slug}"), title, settings });
        Ok::<(), AblateError>(())
    };
    let size = format!("{} × {}", experiment.width(), experiment.height());
    for setting in &outcome.settings {
        let rows: Vec<&Finished> = outcome.rows.iter().filter(|row| row.setting == setting.slug).collect();
        if rows.is_empty() {
            continue;
        }
        for (against, name, words) in [(Against::Time, "time", "time"), (Against::Rays, "rays", "rays")] {
            let title = format!("{}, {size}: error against {words}", setting.label);
            draw(format!("{}-{name}", setting.slug), title, &rows, against, vec![setting.slug.clone()])?;
        }
    }
    if experiment.light_scales.len() > 1 {
        for (index, choice) in experiment.scenes.iter().enumerate() {
            let mine = outcome.settings.iter().filter(|setting| setting.scene == index);
            let slugs: Vec<String> = mine.map(|setting| setting.slug.clone()).collect();
            let rows: Vec<&Finished> =
                outcome.rows.iter().filter(|row| slugs.contains(&row.setting)).collect();
            if !rows.is_empty() {
                let name = super::plan::scene_label(choice);
                let title = format!("{name}, {size}: error against the size of the light");
                draw(
                    format!("{}-light", super::plan::slug(&name)),
                    title,
                    &rows,
                    Against::Light,
                    slugs[..1].to_vec(),
                )?;
            }
        }
    }
    Ok(figures)
}
