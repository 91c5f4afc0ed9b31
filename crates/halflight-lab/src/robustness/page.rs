//! The page: who fails where, why, and what mends it.

use std::fmt::Write;

use super::judge::{DEGRADED, FAILS, GRANTED, NOTHING, Verdict};
use super::methods::{Method, set};
use super::{Cell, REFERENCE_SAMPLES, Row, TITLE};
use crate::report::{self, STYLE, escape};
use crate::results::{Provenance, Table};

const MATRIX: &str = include_str!("page.css");

/// The whole page. All links in it are relative.
pub(super) fn html(rows: &[Row], provenance: &Provenance, command: &str) -> String {
    let mut page = String::new();
    let title = escape(TITLE);
    page += "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
    page += &format!(
        "<title>{title}</title>\n<style>\n{STYLE}{MATRIX}</style>\n</head>\n<body>\n<h1>{title}</h1>\n"
    );
    page += &format!(
        "<p class=\"from\"><code>{}</code><br>commit {}, {}. Every figure is in \
         <a href=\"robustness.csv\">robustness.csv</a>.</p>\n",
        escape(command),
        escape(&provenance.commit),
        escape(&provenance.machine)
    );
    page += &format!(
        "<p>64 light samples, errors (NMSE₂) against {REFERENCE_SAMPLES} by rays. A method <b>passes</b> where its error is at most \
         {DEGRADED:.0} times the yardstick: the larger of its own error in the easy case (up to {GRANTED:.0e}) and of that of every pixel by rays in the \
         same case with the same shading, and at least {NOTHING:.0e}. Beyond that it is <b>degraded</b>, by the factor shown. It \
         <b>fails</b> where the error is above {FAILS:.0e}, or where it is no better than the picture without any \
         shadow. Black: no picture at all (NaN, infinite, negative, panic). Pictures: rendered, reference, error (pale is {} % of \
         the reference's peak and more).</p>\n",
        halflight_image::picture::ERROR_SCALE * 100.0
    );
    let count = |word: &str| cells(rows).filter(|(_, cell)| cell.verdict.word() == word).count();
    page += &format!(
        "<p>{} pictures: {} pass, {} degraded, {} fail.</p>\n",
        cells(rows).count(),
        count("pass"),
        count("degraded"),
        count("fails")
    );
    page += &matrix(rows);
    page += "<h2>Why, and what mends it</h2>\n<p>Methods that do not pass for the same reason. The switch was measured: with it \
             alone the method passes. Where every pixel is the only way, no other choice of one stage was enough.</p>\n";
    page += &report::table(&mended(rows)).replace("<table>", "<table class=\"why\">");
    page += "<h2>Cases</h2>\n";
    let line = |row: &Row| [row.case.to_string(), row.title.to_string(), format!("{:.1e}", row.unshadowed)];
    let columns = ["case", "what there is to stumble over", "NMSE₂ without shadows"];
    page += &report::table(&Table::new(columns, rows.iter().map(line)));
    page += "</body>\n</html>\n";
    page
}

fn cells(rows: &[Row]) -> impl Iterator<Item = (&Row, &Cell)> {
    rows.iter().flat_map(|row| row.cells.iter().map(move |cell| (row, cell)))
}

/// All methods that occur, in the order of the case with most of them.
fn methods(rows: &[Row]) -> Vec<Method> {
    let longest = rows.iter().max_by_key(|row| row.cells.len());
    longest.map_or(Vec::new(), |row| row.cells.iter().map(|cell| cell.method).collect())
}

/// Methods down, cases across; the last columns count, and name the worst case of each method.
fn matrix(rows: &[Row]) -> String {
    let mut html = "<div class=\"wide\"><table class=\"matrix\"><thead><tr><th>method</th>".to_string();
    for row in rows {
        let _ = write!(html, "<th title=\"{}\">{}</th>", escape(row.title), escape(row.case));
    }
    html += "<th>degraded</th><th>fails</th><th>worst picture</th></tr></thead><tbody>\n";
    for method in methods(rows) {
        let _ = write!(html, "<tr><td>{}</td>", escape(&method.label()));
        let own = |row: &'_ Row| row.cells.iter().position(|cell| cell.method == method);
        let mine: Vec<(&Row, Option<&Cell>)> =
            rows.iter().map(|row| (row, own(row).map(|index| &row.cells[index]))).collect();
        for (_, found) in &mine {
            html += &found.map_or("<td></td>".to_string(), cell);
        }
        let there = || mine.iter().filter_map(|(row, found)| Some((*row, (*found)?)));
        for word in ["degraded", "fails"] {
            let _ =
                write!(html, "<td>{}</td>", there().filter(|(_, cell)| cell.verdict.word() == word).count());
        }
        let bad = there().filter(|(_, cell)| cell.picture.is_some() && cell.verdict != Verdict::Pass);
        let worst = bad.max_by(|(_, a), (_, b)| {
            let (a, b) = (a.verdict.badness(), b.verdict.badness());
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        let link = worst.map_or(String::new(), |(row, cell)| {
            format!(
                "<a href=\"{}\">{}</a>",
                escape(cell.picture.as_deref().unwrap_or_default()),
                escape(row.case)
            )
        });
        let _ = writeln!(html, "<td>{link}</td></tr>");
    }
    html + "</tbody></table></div>\n"
}

fn cell(cell: &Cell) -> String {
    let (class, text) = match &cell.verdict {
        Verdict::Pass => ("pass", "·".to_string()),
        Verdict::Degraded(times) | Verdict::Wrong(times) => (cell.verdict.word(), short(*times)),
        Verdict::Broken(_) => ("broken", "!".to_string()),
    };
    let mut said = cell.figure.map_or(String::new(), |figure| format!("NMSE₂ {:.1e}, ", figure.nmse2));
    said += cell.verdict.word();
    if !cell.why.is_empty() {
        said += &format!(": {}", cell.why);
    }
    if !cell.mends.is_empty() {
        said += &format!(". Mended by {}", set(&cell.mends));
    }
    let text = match &cell.picture {
        Some(path) => format!("<a href=\"{}\">{text}</a>", escape(path)),
        None => text,
    };
    format!("<td class=\"{class}\" title=\"{}\">{text}</td>", escape(&said))
}

/// A factor in at most three signs. Errors that are too large for the light but not for the yardstick are `≤ 4`.
fn short(times: f64) -> String {
    match times {
        times if times <= DEGRADED => format!("≤{DEGRADED:.0}"),
        times if times < 999.5 => format!("{times:.0}"),
        times if times < 1e6 => format!("{:.0}k", times / 1e3),
        _ => "∞".to_string(),
    }
}

/// What does not pass, by case and by the switch that mends it.
fn mended(rows: &[Row]) -> Table {
    let mut found: Vec<([String; 3], usize, f64)> = Vec::new();
    for (row, cell) in cells(rows).filter(|(_, cell)| cell.verdict != Verdict::Pass) {
        let change = |switch: &super::Switch| format!("{}: {} → {}", switch.stage, switch.from, switch.to);
        let change = match cell.mends.as_slice() {
            [] => "nothing".to_string(),
            mends => mends.iter().map(change).collect::<Vec<_>>().join(", "),
        };
        let key = [row.case.to_string(), change, cell.why.clone()];
        let times = cell.verdict.times().unwrap_or(f64::NAN);
        match found.iter_mut().find(|(other, ..)| *other == key) {
            Some((_, count, worst)) => (*count, *worst) = (*count + 1, worst.max(times)),
            None => found.push((key, 1, times)),
        }
    }
    let line = |([case, change, why], count, worst): ([String; 3], usize, f64)| {
        [case, change, count.to_string(), short(worst), why]
    };
    Table::new(["case", "mended by", "methods", "worst, times", "why"], found.into_iter().map(line))
}

#[cfg(test)]
mod tests {
    use halflight_cpu::irradiance::Shading;

    use super::super::judge::{Fault, Figure};
    use super::super::methods::Switch;
    use super::*;

    fn page(verdict: Verdict) -> String {
        let cell = Cell {
            method: Method::every_pixel(Shading::Sampled),
            figure: Some(Figure { nmse2: 5e-3, worst: 0.5 }),
            verdict,
            mends: vec![Switch { stage: "shading", to: "ratio".to_string(), from: "sampled".to_string() }],
            why: "a < b".to_string(),
            picture: Some("pictures/easy/full.png".to_string()),
        };
        let row = Row { case: "easy", title: "t", unshadowed: 0.1, cells: vec![cell] };
        let provenance = Provenance {
            commit: "c".into(),
            machine: "m".into(),
            threads: 1,
            device: "cpu".into(),
            program: 0,
        };
        html(&[row], &provenance, "command")
    }

    #[test]
    fn a_cell_says_what_why_and_what_mends_it() {
        let page = page(Verdict::Wrong(37.2));
        for words in [
            "<td class=\"fails\"",
            "<a href=\"pictures/easy/full.png\">37</a>",
            "a &lt; b. Mended by shading = ratio",
            "<td>shading: sampled → ratio</td><td>1</td><td>37</td>",
            "0 pass, 0 degraded, 1 fail",
            "<a href=\"pictures/easy/full.png\">easy</a>",
        ] {
            assert!(page.contains(words), "{words} is missing");
        }
        assert!(!page.contains("://") && !page.contains("href=\"/"));
    }

    #[test]
    fn broken_pictures_stand_out() {
        assert!(page(Verdict::Broken(Fault::NotFinite { x: 1, y: 2 })).contains("<td class=\"broken\""));
    }

    #[test]
    fn factors_are_short() {
        assert_eq!(
            [0.5, 4.5, 37.2, 999.9, 2e5, f64::INFINITY].map(short),
            ["≤4", "4", "37", "1k", "200k", "∞"]
        );
    }
}
