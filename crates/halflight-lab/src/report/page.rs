//! The report: one page with all tables, charts and pictures.

use anyhow::Result;
use itertools::Itertools as _;
use maud::{Markup, PreEscaped, html};
use serde_json::json;

use super::columns::{COLUMNS, Column};
use super::figure::{Figure, Place, charts};
use super::front::front;
use super::html::{page, table};
use crate::analysis::format::integer;
use crate::analysis::{equal_error, equal_time, paper, path, scaling, summary};
use crate::experiment::plan::Setting;
use crate::experiment::{Experiment, Scaling};
use crate::results::record::NOISE_MARGIN;
use crate::results::{self, Finished, Outcome, Table};

const SCRIPT: &str = include_str!("report.js");

/// Returns the report of an experiment. All links in it are relative.
///
/// # Errors
/// The rows cannot be put into JSON.
pub(super) fn report(
    experiment: &Experiment,
    outcome: &Outcome,
    figures: &[Figure],
    command: &str,
) -> Result<String> {
    let provenance = &outcome.provenance;
    let sizes = experiment.sizes.iter().map(|[width, height]| format!("{width} × {height}")).join(", ");
    // "</" would end the script.
    let data = serde_json::to_string(&pictures(experiment, outcome))?.replace("</", "<\\/");
    let body = html! {
        @if experiment.front_page { (front(experiment, outcome, figures)) }
        p { (experiment.description) }
        p.from {
            code { (command) } br;
            "commit " (provenance.commit) ", " (provenance.machine) ", " (provenance.threads) " threads; "
            (sizes) " pixels; warm frames, timed in turn. Every figure is in "
            a href="results.csv" { "results.csv" } "."
        }
        nav { @for setting in &outcome.settings { a href={ "#" (setting.slug) } { (setting.label) } " " } }
        (tables(experiment, outcome))
        (charts(figures, &Place::Experiment))
        @for setting in &outcome.settings {
            @let rows = outcome.rows_of(setting);
            @if !rows.is_empty() { (section(experiment, setting, &rows, figures)) }
            (specular(outcome, setting))
            (indirect(outcome, setting, figures))
        }
        script { (PreEscaped(format!("\nconst SETTINGS = {data};\n{SCRIPT}"))) }
    };
    Ok(page(&experiment.title, "", &body))
}

/// Returns the tables of all settings together: the paper's figures, rows of equal time and error, growth.
fn tables(experiment: &Experiment, outcome: &Outcome) -> Markup {
    let mut found: Vec<(&str, String, Table, &str)> = Vec::new();
    if let Some(paper) = &experiment.paper {
        let ours = paper::table(paper, &outcome.rows);
        found.push((&paper.source, paper.differs.clone(), ours, "paper.csv"));
    }
    if let Some(visibility) = &experiment.equal_time {
        let words =
            format!("Each row of another backend, and the row of {visibility} whose frame time is nearest.");
        found.push(("Equal time", words, equal_time::table(&outcome.rows, visibility), "equal-time.csv"));
    }
    if !experiment.equal_error.is_empty() {
        let words = "How long each method takes to reach an NMSE₂, read off the front of its own knobs (constants and light samples) \
                     as power laws between its points, and the geometric mean over scenes. Never: none of its rows is as \
                     accurate. Scenes whose reference is too noisy for a target are left out of its mean.";
        let summary = equal_error::summary(&outcome.rows, &experiment.equal_error);
        found.push(("Time at equal error", words.to_string(), summary.table(), "summary.csv"));
    }
    if let Some(Scaling { axis }) = experiment.scaling {
        let lines = scaling::lines(&outcome.rows, axis);
        let words = format!(
            "Time of the visibility stage, preparation included, as a power of the number of {}: least squares over the \
             logarithms, with the standard error of the slope.",
            axis.quantity()
        );
        found.push(("Growth", words, scaling::table(&lines, axis), "slopes.csv"));
    }
    if experiment.path.is_some() {
        let words = "Fragments whose visibility was asked for and time of each level, with that visibility, in frames along the animation.";
        found.push(("Work along the animation", words.to_string(), path::table(&outcome.rows), "path.csv"));
    }
    if !outcome.specular.is_empty() {
        let words = "Specular passes by themselves: pixels of glossy surfaces once for each light, pixels in discarded fragments, gathered fragments by level from \
                     single pixels on, lobes that were sampled by a grid; errors of the reflected radiance against converged lobes, of which those without \
                     occluders are for passes that know none.";
        let lines = results::specular::table(&outcome.specular);
        found.push(("Specular passes", words.to_string(), lines, "specular.csv"));
    }
    if !outcome.indirect.is_empty() {
        let words = "Indirect light by itself, against one diffuse reflection: the relative error is the root of NMSE₂ of the luminance less the reference's noise, the bias \
                     the ratio of the means less 1; leaks are pixels of more than 5 % of the mean where the reference has less than 1 %. Points are placed once.";
        let lines = results::indirect::table(&outcome.indirect);
        found.push(("Indirect light", words.to_string(), lines, "indirect.csv"));
    }
    html! {
        @for (title, words, lines, file) in &found {
            h2 { (title) }
            p { (words) }
            @if !lines.lines.is_empty() {
                (table(lines, None))
                p { "The same as " a href=(file) { (file) } "." }
            }
        }
    }
}

/// Returns the pictures of a setting's specular passes, each with the map of its fragments.
fn specular(outcome: &Outcome, setting: &Setting) -> Markup {
    let rows: Vec<_> = outcome.specular.iter().filter(|row| row.setting == setting.slug).collect();
    let folder = format!("pictures/{}", setting.slug);
    html! {
        @if !rows.is_empty() {
            h2 { (setting.label) ": what is reflected specularly" }
            p { "Converged lobes with exact visibility, then the passes, each with its fragments. Dark red: discarded; grey: matte." }
            div.charts {
                figure { img src={ (folder) "/specular-reference.png" } alt="converged" loading="lazy"; figcaption { "converged" } }
                @for row in rows {
                    @for (file, words) in row.pictures().iter().zip(["", ": fragments"]) {
                        figure { img src={ (folder) "/" (file) } alt=(row.label) loading="lazy"; figcaption { (row.label) (words) } }
                    }
                }
            }
        }
    }
}

/// Returns chart and pictures of a setting's indirect light, each picture with the map of its error.
fn indirect(outcome: &Outcome, setting: &Setting, figures: &[Figure]) -> Markup {
    let rows: Vec<_> = outcome.indirect.iter().filter(|row| row.setting == setting.slug).collect();
    let folder = format!("pictures/{}", setting.slug);
    html! {
        @if !rows.is_empty() {
            h2 { (setting.label) ": indirect light" }
            (charts(figures, &Place::Indirect(setting.slug.clone())))
            p { "One diffuse reflection, then the methods: indirect irradiance, brighter than it is, its error, and the image with direct light." }
            div.charts {
                figure { img src={ (folder) "/indirect-reference.png" } alt="reference" loading="lazy"; figcaption { "reference" } }
                @for row in rows {
                    @for (file, words) in row.pictures().iter().zip(["", ": error", ": with direct light"]) {
                        figure { img src={ (folder) "/" (file) } alt=(row.label) loading="lazy"; figcaption { (row.label) (words) } }
                    }
                }
            }
        }
    }
}

/// Returns summary, charts, viewer and table of a setting.
fn section(experiment: &Experiment, setting: &Setting, rows: &[&Finished], figures: &[Figure]) -> Markup {
    let slug = &setting.slug;
    let triangles = integer(rows.first().map(|row| row.record.triangles));
    let frames = experiment.repetitions_of(setting.scene);
    let columns: Vec<&Column> =
        COLUMNS.iter().filter(|(_, cell)| rows.iter().any(|row| !cell(row).is_empty())).collect();
    html! {
        section id=(slug) {
            h2 { (setting.label) }
            p { (triangles) " triangles; times are medians of " (frames) " frames." }
            ul { @for sentence in summary::sentences(rows) { li { (sentence) } } }
            (charts(figures, &Place::Setting(slug.clone())))
            div.viewer data-setting=(slug) {}
            p {
                "Click a row to see it as A, shift-click to see it as B. Error maps: black is none, the bright end is "
                (experiment.error_scale * 100.0)
                " % of the reference's peak or more, grey sees nothing. ‡: less than "
                (format!("{NOISE_MARGIN:.0}")) " times the reference's own error."
            }
            div.wide {
                table.sortable data-setting=(slug) {
                    thead { tr { @for (title, _) in &columns { th { (title) } } } }
                    tbody {
                        @for row in rows {
                            tr data-row=(row.row) { @for (_, cell) in &columns { td { (cell(row)) } } }
                        }
                    }
                }
            }
        }
    }
}

/// Returns the data of the viewer: size, reference and pictures of the rows of each setting.
fn pictures(experiment: &Experiment, outcome: &Outcome) -> serde_json::Value {
    let of = |setting: &Setting| {
        let folder = format!("pictures/{}", setting.slug);
        let row = |row: &Finished| {
            let files = results::pictures(row, experiment).into_iter();
            let files: serde_json::Map<_, _> =
                files.map(|(name, file)| (name.to_string(), format!("{folder}/{file}").into())).collect();
            json!({ "row": row.row, "label": row.label, "files": files, "error": row.record.nmse2, "ms": row.record.total_ms })
        };
        let rows: Vec<_> = outcome.rows_of(setting).into_iter().map(row).collect();
        (
            setting.slug.clone(),
            json!({
                "width": setting.size[0],
                "height": setting.size[1],
                "reference": format!("{folder}/reference.png"),
                "rows": rows,
            }),
        )
    };
    outcome.settings.iter().map(of).collect::<serde_json::Map<_, _>>().into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::{Axis, plan};
    use crate::results::Provenance;
    use crate::results::record::tests::finished;

    fn whole() -> (Outcome, String) {
        let mut experiment = Experiment::resolve("koa-fig8").unwrap();
        experiment.set_scenes(&["/elsewhere/hall.toml".to_string()]);
        experiment.description = "a < b & c".to_string();
        let outcome = Outcome {
            settings: plan::settings(&experiment),
            rows: vec![
                finished("nichols", "delaunay", 12.0, 3e-4),
                finished("sfvt-gass", "rbf-fixed", 20.0, 2e-4),
            ],
            specular: Vec::new(),
            indirect: Vec::new(),
            provenance: Provenance {
                commit: "abc1234-dirty".to_string(),
                machine: "a processor, 2 cores, linux".to_string(),
                ..Provenance::default()
            },
        };
        let figure = Figure {
            path: "charts/hall-time".to_string(),
            title: "hall".to_string(),
            place: Place::Setting("hall".to_string()),
        };
        let page = report(&experiment, &outcome, &[figure], "cargo xtask ablate koa-fig8").unwrap();
        (outcome, page)
    }

    #[test]
    fn it_shows_every_row_with_its_pictures() {
        let (outcome, page) = whole();
        for row in &outcome.rows {
            assert!(page.contains(&format!("data-row=\"{}\"", row.row)));
            for ending in [".png", "-error.png", "-squared.png"] {
                assert!(page.contains(&format!("pictures/hall/{}{ending}", row.row)), "{ending}");
            }
            assert!(page.contains(&format!("pictures/hall/{}-fragments.png", row.fragments)));
        }
        // Neither voxels nor a paper's kind of reference here.
        assert!(!page.contains("off %") && page.contains("<th>certified lit</th>"));
        for words in [
            "abc1234-dirty",
            "a processor",
            "cargo xtask ablate koa-fig8",
            "charts/hall-time.png",
            "Pareto front of time",
        ] {
            assert!(page.contains(words), "{words} is missing");
        }
    }

    #[test]
    fn failures_and_growth_are_shown_where_there_are_any() {
        let mut experiment = Experiment::resolve("voxel").unwrap();
        experiment.set_scenes(&["hall".to_string()]);
        experiment.scaling = Some(Scaling { axis: Axis::Pixels });
        experiment.equal_time = Some("bvh".to_string());
        let (mut outcome, _) = whole();
        (outcome.settings, outcome.rows) = (plan::settings(&experiment), outcome.rows);
        outcome.rows[0].record.visibility = "voxel".to_string();
        outcome.rows[0].record.off_share = Some(0.125);
        let figure =
            Figure { path: "charts/scaling".to_string(), title: "g".to_string(), place: Place::Experiment };
        let page = report(&experiment, &outcome, &[figure], "command").unwrap();
        for words in [
            "<th>off %</th>",
            "<td>12.50</td>",
            "slopes.csv",
            "equal-time.csv",
            "charts/scaling.png",
            "nichols-delaunay-failures.png",
        ] {
            assert!(page.contains(words), "{words} is missing");
        }
    }

    #[test]
    fn it_holds_no_address_and_no_absolute_path() {
        let (_, page) = whole();
        assert!(page.contains("a &lt; b &amp; c"));
        for wrong in ["://", "href=\"/", "src=\"/", "/elsewhere", "\"/"] {
            assert!(!page.contains(wrong), "{wrong} is there");
        }
    }
}
