//! One page with all tables, charts and pictures; it needs no network.

use std::fmt::Write;

use serde_json::json;

use super::columns::{COLUMNS, Column};
use super::html::{self, STYLE, escape};
use crate::analysis::format::integer;
use crate::analysis::{equal_error, equal_time, paper, scaling, summary};
use crate::error::AblateError;
use crate::experiment::plan::Setting;
use crate::experiment::{Experiment, Scaling};
use crate::results::record::NOISE_MARGIN;
use crate::results::{self, Finished, Outcome, Table};

const SCRIPT: &str = include_str!("report.js");

/// A chart on the page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Figure {
    /// Path from the page, without ending.
    pub(super) path: String,
    /// Title.
    pub(super) title: String,
    /// Slugs of the settings under which it stands; none for all of the experiment.
    pub(super) settings: Vec<String>,
}

/// The page. All links in it are relative.
///
/// # Errors
/// The rows cannot be put into JSON.
pub(super) fn page(
    experiment: &Experiment,
    outcome: &Outcome,
    figures: &[Figure],
    command: &str,
) -> Result<String, AblateError> {
    let mut page = String::new();
    let provenance = &outcome.provenance;
    let title = escape(&experiment.title);
    page += "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
    page += &format!("<title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n");
    page += &format!("<h1>{title}</h1>\n<p>{}</p>\n", escape(&experiment.description));
    let sizes: Vec<String> =
        experiment.sizes.iter().map(|[width, height]| format!("{width} × {height}")).collect();
    page += &format!(
        "<p class=\"from\"><code>{}</code><br>commit {}, {}, {} threads; {} pixels; warm frames, timed in turn. \
         Every figure is in <a href=\"results.csv\">results.csv</a>.</p>\n",
        escape(command),
        escape(&provenance.commit),
        escape(&provenance.machine),
        provenance.threads,
        sizes.join(", ")
    );
    page += "<nav>";
    for setting in &outcome.settings {
        page += &format!("<a href=\"#{}\">{}</a> ", setting.slug, escape(&setting.label));
    }
    page += "</nav>\n";
    tables(&mut page, experiment, outcome, figures);
    for setting in &outcome.settings {
        let rows: Vec<&Finished> = outcome.rows.iter().filter(|row| row.setting == setting.slug).collect();
        if !rows.is_empty() {
            section(&mut page, experiment, setting, &rows, figures);
        }
    }
    let data = pictures(experiment, outcome);
    // "</" would end the script.
    let data = serde_json::to_string(&data)?.replace("</", "<\\/");
    page += &format!("<script>\nconst SETTINGS = {data};\n{SCRIPT}</script>\n</body>\n</html>\n");
    Ok(page)
}

/// What is said about all settings together: the paper's figures, rows of equal time, growth.
fn tables(page: &mut String, experiment: &Experiment, outcome: &Outcome, figures: &[Figure]) {
    let mut add = |title: &str, words: &str, table: Table, file: &str| {
        page.push_str(&format!("<h2>{}</h2>\n<p>{}</p>\n", escape(title), escape(words)));
        if !table.lines.is_empty() {
            let link = format!("<p>The same as <a href=\"{file}\">{file}</a>.</p>\n");
            page.push_str(&(html::table(&table) + &link));
        }
    };
    if let Some(paper) = &experiment.paper {
        add(&paper.source, &paper.differs, paper::table(paper, &outcome.rows), "paper.csv");
    }
    if let Some(visibility) = &experiment.equal_time {
        let words =
            format!("Each row of another backend, and the row of {visibility} whose frame time is nearest.");
        add("Equal time", &words, equal_time::table(&outcome.rows, visibility), "equal-time.csv");
    }
    if !experiment.equal_error.is_empty() {
        let words = "How long each method takes to reach an NMSE₂, read off the front of its own knobs (constants and light samples) \
                     as power laws between its points, and the geometric mean over scenes. Never: none of its rows is as \
                     accurate. Scenes whose reference is too noisy for a target are left out of its mean.";
        let summary = equal_error::summary(&outcome.rows, &experiment.equal_error);
        add("Time at equal error", words, summary.table(), "summary.csv");
    }
    if let Some(Scaling { axis }) = experiment.scaling {
        let lines = scaling::lines(&outcome.rows, axis);
        let words = format!(
            "Time of the visibility stage, preparation included, as a power of the number of {}: least squares over the \
             logarithms, with the standard error of the slope.",
            axis.quantity()
        );
        add("Growth", &words, scaling::table(&lines, axis), "slopes.csv");
    }
    page.push_str("<div class=\"charts\">\n");
    figures.iter().filter(|figure| figure.settings.is_empty()).for_each(|one| figure(page, one));
    page.push_str("</div>\n");
}

fn figure(page: &mut String, Figure { path, title, .. }: &Figure) {
    let title = escape(title);
    page.push_str(&format!(
        "<figure><a href=\"{path}.svg\"><img src=\"{path}.png\" alt=\"{title}\" loading=\"lazy\"></a></figure>\n"
    ));
}

/// Summary, charts, viewer and table of a setting.
fn section(
    page: &mut String,
    experiment: &Experiment,
    setting: &Setting,
    rows: &[&Finished],
    figures: &[Figure],
) {
    let slug = &setting.slug;
    let triangles = integer(rows.first().map(|row| row.record.triangles));
    page.push_str(&format!("<section id=\"{slug}\">\n<h2>{}</h2>\n", escape(&setting.label)));
    let frames = experiment.repetitions_of(setting.scene);
    page.push_str(&format!("<p>{triangles} triangles; times are medians of {frames} frames.</p>\n<ul>\n"));
    for sentence in summary::sentences(rows) {
        page.push_str(&format!("<li>{}</li>\n", escape(&sentence)));
    }
    page.push_str("</ul>\n<div class=\"charts\">\n");
    figures.iter().filter(|figure| figure.settings.contains(slug)).for_each(|one| figure(page, one));
    let _ = write!(
        page,
        "</div>\n<div class=\"viewer\" data-setting=\"{slug}\"></div>\n\
         <p>Click a row to see it as A, shift-click to see it as B. Error maps: black is none, the bright end is {} % of the \
         reference's peak or more, grey sees nothing. ‡: less than {NOISE_MARGIN:.0} times the reference's own error.</p>\n\
         <div class=\"wide\"><table class=\"sortable\" data-setting=\"{slug}\"><thead><tr>",
        experiment.error_scale * 100.0
    );
    let columns: Vec<&Column> =
        COLUMNS.iter().filter(|(_, cell)| rows.iter().any(|row| !cell(row).is_empty())).collect();
    for (title, _) in &columns {
        page.push_str(&format!("<th>{title}</th>"));
    }
    page.push_str("</tr></thead><tbody>\n");
    for row in rows {
        page.push_str(&format!("<tr data-row=\"{}\">", escape(&row.row)));
        for (_, cell) in &columns {
            page.push_str(&format!("<td>{}</td>", escape(&cell(row))));
        }
        page.push_str("</tr>\n");
    }
    page.push_str("</tbody></table></div>\n</section>\n");
}

/// What the viewer needs: of each setting its size, its reference and the pictures of its rows.
fn pictures(experiment: &Experiment, outcome: &Outcome) -> serde_json::Value {
    let of = |setting: &Setting| {
        let folder = format!("pictures/{}", setting.slug);
        let row = |row: &Finished| {
            let files = results::pictures(row, experiment).into_iter();
            let files: serde_json::Map<_, _> =
                files.map(|(name, file)| (name.to_string(), format!("{folder}/{file}").into())).collect();
            json!({ "row": row.row, "label": row.label, "files": files, "error": row.record.nmse2, "ms": row.record.total_ms })
        };
        let rows: Vec<_> = outcome.rows.iter().filter(|row| row.setting == setting.slug).map(row).collect();
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
            provenance: Provenance {
                commit: "abc1234-dirty".to_string(),
                machine: "a processor, 2 cores, linux".to_string(),
                threads: 2,
                device: "cpu".to_string(),
                program: 0,
            },
        };
        let figure = Figure {
            path: "charts/hall-time".to_string(),
            title: "hall".to_string(),
            settings: vec!["hall".to_string()],
        };
        let page = page(&experiment, &outcome, &[figure], "cargo xtask ablate koa-fig8").unwrap();
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
        assert!(!page.contains("off %") && page.contains("<th>proved lit</th>"));
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
            Figure { path: "charts/scaling".to_string(), title: "g".to_string(), settings: Vec::new() };
        let page = page(&experiment, &outcome, &[figure], "command").unwrap();
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
