//! One page with all tables, charts and pictures; it needs no network.

use std::fmt::Write;

use serde_json::json;

use super::experiment::Experiment;
use super::paper::{self, error, integer, time};
use super::plan::Setting;
use super::record::{Finished, NOISE_MARGIN};
use super::run::{self, Outcome};
use super::{AblateError, summary};

const STYLE: &str = include_str!("report/report.css");
const SCRIPT: &str = include_str!("report/report.js");

/// A chart on the page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    /// Path from the page, without ending.
    pub path: String,
    /// Title.
    pub title: String,
    /// Slugs of the settings under which it stands.
    pub settings: Vec<String>,
}

/// The page. All links in it are relative.
///
/// # Errors
/// The rows cannot be put into JSON.
pub fn html(
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
    page += &format!(
        "<p class=\"from\"><code>{}</code><br>commit {}, {}, {} threads; {} × {} pixels; warm frames, timed in turn. \
         Every figure is in <a href=\"results.csv\">results.csv</a>.</p>\n",
        escape(command),
        escape(&provenance.commit),
        escape(&provenance.machine),
        provenance.threads,
        experiment.width(),
        experiment.height()
    );
    page += "<nav>";
    for setting in &outcome.settings {
        page += &format!("<a href=\"#{}\">{}</a> ", setting.slug, escape(&setting.label));
    }
    page += "</nav>\n";
    paper_table(&mut page, experiment, outcome);
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

fn paper_table(page: &mut String, experiment: &Experiment, outcome: &Outcome) {
    let Some(paper) = &experiment.paper else { return };
    page.push_str(&format!("<h2>{}</h2>\n<p>{}</p>\n", escape(&paper.source), escape(&paper.differs)));
    let lines = paper::lines(paper, &outcome.rows);
    if lines.is_empty() {
        return;
    }
    page.push_str("<div class=\"wide\"><table><thead><tr>");
    for column in paper::COLUMNS {
        page.push_str(&format!("<th>{}</th>", escape(column)));
    }
    page.push_str("</tr></thead><tbody>\n");
    for line in lines {
        page.push_str(if line.from_paper { "<tr class=\"paper\">" } else { "<tr>" });
        for cell in &line.cells {
            page.push_str(&format!("<td>{}</td>", escape(cell)));
        }
        page.push_str("</tr>\n");
    }
    page.push_str("</tbody></table></div>\n<p>The same as <a href=\"paper.csv\">paper.csv</a>.</p>\n");
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
    for figure in figures.iter().filter(|figure| figure.settings.contains(slug)) {
        let (path, title) = (&figure.path, escape(&figure.title));
        page.push_str(&format!(
            "<figure><a href=\"{path}.svg\"><img src=\"{path}.png\" alt=\"{title}\" loading=\"lazy\"></a></figure>\n"
        ));
    }
    let _ = write!(
        page,
        "</div>\n<div class=\"viewer\" data-setting=\"{slug}\"></div>\n\
         <p>Click a row to see it as A, shift-click to see it as B. Error maps: black is none, the bright end is {} % of the \
         reference's peak or more, grey sees nothing. ‡: less than {NOISE_MARGIN:.0} times the reference's own error.</p>\n\
         <div class=\"wide\"><table class=\"sortable\" data-setting=\"{slug}\"><thead><tr>",
        experiment.error_scale * 100.0
    );
    for column in COLUMNS {
        page.push_str(&format!("<th>{column}</th>"));
    }
    page.push_str("</tr></thead><tbody>\n");
    for row in rows {
        page.push_str(&format!("<tr data-row=\"{}\">", escape(&row.row)));
        for cell in cells(row) {
            page.push_str(&format!("<td>{}</td>", escape(&cell)));
        }
        page.push_str("</tr>\n");
    }
    page.push_str("</tbody></table></div>\n</section>\n");
}

const COLUMNS: [&str; 21] = [
    "refiner",
    "parameters",
    "upsampler",
    "shading",
    "samples",
    "pattern",
    "fragments",
    "rays",
    "G-buffer ms",
    "pyramid ms",
    "refine ms",
    "visibility ms",
    "irradiance ms",
    "upsample ms",
    "compose ms",
    "total ms",
    "NMSE₂",
    "NMSE",
    "relMSE",
    "SSIM",
    "ꟻLIP",
];

fn cells(row: &Finished) -> [String; COLUMNS.len()] {
    let record = &row.record;
    let mark = if record.near_noise() { " ‡" } else { "" };
    [
        record.refiner.clone(),
        record.parameters.clone(),
        record.upsampler.clone(),
        record.shading.clone(),
        record.samples.to_string(),
        format!("{} / {}", record.pattern, record.sharing),
        integer(Some(record.fragments)),
        integer(Some(record.rays)),
        time(Some(record.gbuffer_ms)),
        time(Some(record.pyramid_ms)),
        time(Some(record.refine_ms)),
        time(Some(record.visibility_ms)),
        time(Some(record.irradiance_ms)),
        time(Some(record.upsample_ms)),
        time(Some(record.compose_ms)),
        time(Some(record.total_ms)),
        format!("{}{mark}", error(Some(record.nmse2))),
        error(Some(record.nmse)),
        error(Some(record.relmse)),
        format!("{:.4}", record.ssim),
        format!("{:.4}", record.flip),
    ]
}

/// What the viewer needs: of each setting its size, its reference and the pictures of its rows.
fn pictures(experiment: &Experiment, outcome: &Outcome) -> serde_json::Value {
    let of = |setting: &Setting| {
        let folder = format!("pictures/{}", setting.slug);
        let row = |row: &Finished| {
            let files: Vec<String> =
                run::pictures(row, experiment).iter().map(|name| format!("{folder}/{name}")).collect();
            json!({ "row": row.row, "label": row.label, "files": files, "error": row.record.nmse2, "ms": row.record.total_ms })
        };
        let rows: Vec<_> = outcome.rows.iter().filter(|row| row.setting == setting.slug).map(row).collect();
        (
            setting.slug.clone(),
            json!({
                "width": experiment.width(),
                "height": experiment.height(),
                "reference": format!("{folder}/reference.png"),
                "rows": rows,
            }),
        )
    };
    outcome.settings.iter().map(of).collect::<serde_json::Map<_, _>>().into()
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::super::provenance::Provenance;
    use super::super::record::tests::finished;
    use super::*;

    fn page() -> (Outcome, String) {
        let mut experiment = Experiment::resolve("koa-fig8").unwrap();
        experiment.set_scenes(&["/elsewhere/hall.toml".to_string()]);
        experiment.description = "a < b & c".to_string();
        let outcome = Outcome {
            settings: super::super::plan::settings(&experiment),
            rows: vec![
                finished("nichols", "delaunay", 12.0, 3e-4),
                finished("sfvt-gass", "rbf-fixed", 20.0, 2e-4),
            ],
            provenance: Provenance {
                commit: "abc1234-dirty".to_string(),
                machine: "a processor, 2 cores, linux".to_string(),
                threads: 2,
                program: 0,
            },
        };
        let figure = Figure {
            path: "charts/hall-time".to_string(),
            title: "hall".to_string(),
            settings: vec!["hall".to_string()],
        };
        let page = html(&experiment, &outcome, &[figure], "cargo xtask ablate koa-fig8").unwrap();
        (outcome, page)
    }

    #[test]
    fn it_shows_every_row_with_its_pictures() {
        let (outcome, page) = page();
        for row in &outcome.rows {
            assert!(page.contains(&format!("data-row=\"{}\"", row.row)));
            for ending in [".png", "-error.png", "-squared.png"] {
                assert!(page.contains(&format!("pictures/hall/{}{ending}", row.row)), "{ending}");
            }
            assert!(page.contains(&format!("pictures/hall/{}-fragments.png", row.fragments)));
        }
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
    fn it_holds_no_address_and_no_absolute_path() {
        let (_, page) = page();
        assert!(page.contains("a &lt; b &amp; c"));
        for wrong in ["://", "href=\"/", "src=\"/", "/elsewhere", "\"/"] {
            assert!(!page.contains(wrong), "{wrong} is there");
        }
    }
}
