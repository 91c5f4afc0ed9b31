//! Files of a finished experiment.

use std::path::{Path, PathBuf};

use anyhow::Result;
use halflight_metrics::write_file;
use itertools::iproduct;

use super::figure::{Figure, Place};
use super::page::report;
use crate::analysis::{Measure, equal_error, equal_time, flicker, paper, path, scaling};
use crate::experiment::plan::{scene_label, slug};
use crate::experiment::{AnimationFrames, Experiment, Scaling};
use crate::plot::errors::{self, Against};
use crate::plot::path::Quantity;
use crate::plot::{self, Drawing};
use crate::results::record::write_csv;
use crate::results::{Finished, Outcome, indirect, specular};

/// Writes `results.csv`, the tables that the experiment asks for (`paper.csv`, `equal-time.csv`, `summary.csv`, `slopes.csv`, `flicker.csv`, `path.csv`, `specular.csv`, `indirect.csv`), the charts
/// and `report.html`, which names the `command` that made it.
///
/// # Errors
/// A chart cannot be drawn or a file not be written.
pub fn write(experiment: &Experiment, outcome: &Outcome, out: &Path, command: &str) -> Result<()> {
    write_csv(&out.join("results.csv"), outcome.rows.iter().map(|row| &row.record))?;
    if let Some(paper) = &experiment.paper
        && !paper.rows.is_empty()
    {
        paper::table(paper, &outcome.rows).write_csv(&out.join("paper.csv"))?;
    }
    if let Some(visibility) = &experiment.equal_time {
        equal_time::table(&outcome.rows, visibility).write_csv(&out.join("equal-time.csv"))?;
    }
    if !experiment.equal_error.is_empty() {
        let summary = equal_error::summary(&outcome.rows, &experiment.equal_error);
        summary.table().write_csv(&out.join("summary.csv"))?;
    }
    if let Some(Scaling { axis }) = experiment.scaling {
        let lines = scaling::lines(&outcome.rows, axis);
        scaling::table(&lines, axis).write_csv(&out.join("slopes.csv"))?;
    }
    if experiment.flicker.is_some() {
        flicker::table(&outcome.rows).write_csv(&out.join("flicker.csv"))?;
    }
    if experiment.path.is_some() {
        path::table(&outcome.rows).write_csv(&out.join("path.csv"))?;
    }
    if !outcome.specular.is_empty() {
        specular::table(&outcome.specular).write_csv(&out.join("specular.csv"))?;
    }
    if !outcome.indirect.is_empty() {
        indirect::table(&outcome.indirect).write_csv(&out.join("indirect.csv"))?;
    }
    let figures = charts(experiment, outcome, out)?;
    let html = report(experiment, outcome, &figures, command)?;
    write_file(&out.join("report.html"), html.as_bytes())?;
    Ok(())
}

/// Draws the charts and returns their paths.
fn charts(experiment: &Experiment, outcome: &Outcome, out: &Path) -> Result<Vec<Figure>> {
    let folder = out.join("charts");
    fs_err::create_dir_all(&folder)?;
    let mut charts = Charts { folder, figures: Vec::new() };
    if let Some(Scaling { axis }) = experiment.scaling {
        let lines = scaling::lines(&outcome.rows, axis);
        let title = format!("Visibility against {}", axis.quantity());
        charts.draw("scaling".to_string(), &plot::scaling::chart(title, &lines, axis), Place::Experiment)?;
    }
    if !experiment.equal_error.is_empty() {
        let summary = equal_error::summary(&outcome.rows, &experiment.equal_error);
        charts.draw("summary".to_string(), &plot::equal_error::chart(&summary), Place::Experiment)?;
    }
    if let Some(chart) = plot::expected::chart("Expected and true error".to_string(), &outcome.rows) {
        charts.draw("expected".to_string(), &chart, Place::Experiment)?;
    }
    for (setting, short) in outcome.settings.iter().zip(outcome.names()) {
        let title = format!("{}: indirect light", sized(&setting.label, experiment));
        let reflected = outcome.indirect.iter().filter(|row| row.setting == setting.slug);
        if let Some(chart) = plot::indirect::chart(title, &reflected.collect::<Vec<_>>()) {
            charts.draw(
                format!("{}-indirect", setting.slug),
                &chart,
                Place::Indirect(setting.slug.clone()),
            )?;
        }
        let rows = outcome.rows_of(setting);
        if rows.is_empty() {
            continue;
        }
        if experiment.front_page
            && let Some(chart) = plot::families::chart(short.to_string(), &rows, Measure::FlipP99)
        {
            charts.draw(format!("{}-families", setting.slug), &chart, Place::Front)?;
        }
        let (name, here) = (sized(&setting.label, experiment), Place::Setting(setting.slug.clone()));
        if experiment.scaling.is_none() {
            for (measure, against, words, file) in [
                (Measure::Nmse2, Against::Time, "error against time", "time"),
                (Measure::FlipP99, Against::Time, "FLIP against time", "time-flip"),
                (Measure::Grain, Against::Time, "grain against time", "time-grain"),
                (Measure::Nmse2, Against::Rays, "error against rays", "rays"),
            ] {
                if let Some(chart) = errors::chart(format!("{name}: {words}"), &rows, measure, against) {
                    charts.draw(format!("{}-{file}", setting.slug), &chart, here.clone())?;
                }
            }
        }
        if let Some(constant) = &experiment.sweep
            && let Some(chart) =
                plot::sweep::chart(format!("{name}: error against {constant}"), &rows, constant)
        {
            charts.draw(format!("{}-{}", setting.slug, slug(constant)), &chart, here.clone())?;
        }
        if let Some(constant) = &experiment.sweep
            && let Some(chart) =
                plot::sweep::times(format!("{name}: time against {constant}"), &rows, constant)
        {
            charts.draw(format!("{}-{}-time", setting.slug, slug(constant)), &chart, here.clone())?;
        }
        for (quantity, words, file) in [
            (Quantity::Share, "rendered fragments along the animation", "path-fragments"),
            (Quantity::Time, "time of each level along the animation", "path-time"),
        ] {
            if let Some(chart) = plot::path::chart(format!("{name}: {words}"), &rows, quantity) {
                charts.draw(format!("{}-{file}", setting.slug), &chart, here.clone())?;
            }
        }
        if let Some(AnimationFrames { frames, step }) = experiment.flicker {
            let title = format!("{name}: flicker over {frames} frames, {:.1} ms apart", step * 1e3);
            charts.draw(format!("{}-flicker", setting.slug), &plot::flicker::bars(title, &rows), here)?;
        }
    }
    if experiment.light_scales.len() > 1 {
        for ((index, choice), &size) in iproduct!(experiment.scenes.iter().enumerate(), &experiment.sizes) {
            let mine =
                outcome.settings.iter().filter(|setting| (setting.scene, setting.size) == (index, size));
            let slugs: Vec<String> = mine.map(|setting| setting.slug.clone()).collect();
            let rows: Vec<&Finished> =
                outcome.rows.iter().filter(|row| slugs.contains(&row.setting)).collect();
            let [width, height] = size;
            let title =
                format!("{}, {width} × {height}: error against the size of the light", scene_label(choice));
            if let Some(chart) = errors::chart(title, &rows, Measure::Nmse, Against::Light) {
                charts.draw(format!("{}-light", slugs[0]), &chart, Place::Setting(slugs[0].clone()))?;
            }
        }
    }
    Ok(charts.figures)
}

/// Charts that have been drawn.
struct Charts {
    folder: PathBuf,
    figures: Vec<Figure>,
}

impl Charts {
    fn draw(&mut self, slug: String, drawing: &impl Drawing, place: Place) -> Result<()> {
        drawing.write(&self.folder.join(&slug))?;
        let title = drawing.title().to_string();
        self.figures.push(Figure { path: format!("charts/{slug}"), title, place });
        Ok(())
    }
}

/// Returns a setting's label with the size of the image, which labels have only where there are several.
fn sized(label: &str, experiment: &Experiment) -> String {
    match experiment.sizes.as_slice() {
        [[width, height]] => format!("{label}, {width} × {height}"),
        _ => label.to_string(),
    }
}
