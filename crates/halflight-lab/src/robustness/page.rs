//! Page of the robustness suite: methods against cases, with reasons and what mends them.

use indexmap::IndexMap;
use itertools::Itertools as _;
use maud::{Markup, html};

use super::judge::{DEGRADED, FAILS, GRANTED, NOTHING, Verdict};
use super::methods::{Method, Switch, set};
use super::{Cell, REFERENCE_SAMPLES, Row, TITLE};
use crate::report;
use crate::results::{Provenance, Table};

const MATRIX: &str = include_str!("page.css");

/// Returns the whole page. All links in it are relative.
pub(super) fn whole(rows: &[Row], provenance: &Provenance, command: &str) -> String {
    let count = |word: &str| cells(rows).filter(|(_, cell)| cell.verdict.word() == word).count();
    let line = |row: &Row| [row.case.to_string(), row.title.to_string(), format!("{:.1e}", row.unshadowed)];
    let columns = ["case", "what there is to stumble over", "NMSE₂ without shadows"];
    let [degraded, granted] = [format!("{DEGRADED:.0}"), format!("{GRANTED:.0e}")];
    let [nothing, fails] = [NOTHING, FAILS].map(|limit| format!("{limit:.0e}"));
    let body = html! {
        p.from {
            code { (command) } br;
            "commit " (provenance.commit) ", " (provenance.machine) ". Every figure is in "
            a href="robustness.csv" { "robustness.csv" } "."
        }
        p {
            "64 light samples, errors (NMSE₂) against " (REFERENCE_SAMPLES) " by rays. A method " b { "passes" }
            " where its error is at most " (degraded) " times the yardstick: the larger of its own error in the easy case (up to "
            (granted) ") and of that of every pixel by rays in the same case with the same shading, and at least " (nothing)
            ". Beyond that it is " b { "degraded" } ", by the factor shown. It " b { "fails" } " where the error is above " (fails)
            ", or where it is no better than the picture without any shadow. Black: no picture at all (NaN, infinite, negative, \
             panic). Pictures: rendered, reference, error (pale is "
            (halflight_image::picture::ERROR_SCALE * 100.0) " % of the reference's peak and more)."
        }
        p {
            (cells(rows).count()) " pictures: " (count("pass")) " pass, " (count("degraded")) " degraded, "
            (count("fails")) " fail."
        }
        (matrix(rows))
        h2 { "Why, and what mends it" }
        p {
            "Methods that do not pass for the same reason. The switch was measured: with it alone the method passes. Where every \
             pixel is the only way, no other choice of one stage was enough."
        }
        (report::table(&mended(rows), Some("why")))
        h2 { "Cases" }
        (report::table(&Table::new(columns, rows.iter().map(line)), None))
    };
    report::page(TITLE, MATRIX, &body)
}

fn cells(rows: &[Row]) -> impl Iterator<Item = (&Row, &Cell)> {
    rows.iter().flat_map(|row| row.cells.iter().map(move |cell| (row, cell)))
}

/// Returns methods down, cases across; the last columns count, and name the worst case of each method.
fn matrix(rows: &[Row]) -> Markup {
    // All methods that occur, in the order of the case with most of them.
    let methods = rows.iter().max_by_key(|row| row.cells.len()).map_or(&[][..], |row| &row.cells);
    html! {
        div.wide {
            table.matrix {
                thead {
                    tr {
                        th { "method" }
                        @for row in rows { th title=(row.title) { (row.case) } }
                        th { "degraded" }
                        th { "fails" }
                        th { "worst picture" }
                    }
                }
                tbody { @for Cell { method, .. } in methods { (line(rows, method)) } }
            }
        }
    }
}

/// Returns a line of the matrix.
fn line(rows: &[Row], method: &Method) -> Markup {
    let own = |row: &'_ Row| row.cells.iter().position(|cell| cell.method == *method);
    let mine = rows.iter().map(|row| (row, own(row).map(|index| &row.cells[index]))).collect_vec();
    let there = || mine.iter().filter_map(|(row, found)| Some((*row, (*found)?)));
    let count = |word: &str| there().filter(|(_, cell)| cell.verdict.word() == word).count();
    let bad = there().filter(|(_, cell)| cell.verdict != Verdict::Pass);
    let pictures = bad.filter_map(|(row, cell)| Some((row, cell, cell.picture.as_ref()?)));
    let worst = pictures.max_by(|(_, a, _), (_, b, _)| {
        let (a, b) = (a.verdict.badness(), b.verdict.badness());
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    html! {
        tr {
            td { (method.label()) }
            @for (_, found) in &mine {
                @match found { Some(found) => (cell(found)), None => td {} }
            }
            td { (count("degraded")) }
            td { (count("fails")) }
            td { @if let Some((row, _, path)) = worst { a href=(path) { (row.case) } } }
        }
    }
}

/// Returns a cell of the matrix.
fn cell(cell: &Cell) -> Markup {
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
    html! {
        td class=(class) title=(said) {
            @match &cell.picture { Some(path) => a href=(path) { (text) }, None => (text) }
        }
    }
}

/// Returns a factor in at most three signs. Errors that are too large for the light but not for the yardstick are `≤ 4`.
fn short(times: f64) -> String {
    match times {
        times if times <= DEGRADED => format!("≤{DEGRADED:.0}"),
        times if times < 999.5 => format!("{times:.0}"),
        times if times < 1e6 => format!("{:.0}k", times / 1e3),
        _ => "∞".to_string(),
    }
}

/// Returns the cells that do not pass, by case and by the switches that mend them.
fn mended(rows: &[Row]) -> Table {
    let mut found: IndexMap<[String; 3], (usize, f64)> = IndexMap::new();
    for (row, cell) in cells(rows).filter(|(_, cell)| cell.verdict != Verdict::Pass) {
        let change = |switch: &Switch| format!("{}: {} → {}", switch.stage, switch.from, switch.to);
        let change = match cell.mends.as_slice() {
            [] => "nothing".to_string(),
            mends => mends.iter().map(change).join(", "),
        };
        let key = [row.case.to_string(), change, cell.why.clone()];
        let (count, worst) = found.entry(key).or_insert((0, f64::NAN));
        (*count, *worst) = (*count + 1, worst.max(cell.verdict.times().unwrap_or(f64::NAN)));
    }
    let line = |([case, change, why], (count, worst)): ([String; 3], (usize, f64))| {
        [case, change, count.to_string(), short(worst), why]
    };
    Table::new(["case", "mended by", "methods", "worst, times", "why"], found.into_iter().map(line))
}

#[cfg(test)]
mod tests {
    use halflight_cpu::irradiance::Shading;

    use super::super::judge::{Fault, Figure};
    use super::*;

    fn page(verdict: Verdict) -> String {
        let cell = Cell {
            method: Method::every_pixel(Shading::Sampled),
            figure: Some(Figure { nmse2: 5e-3, worst: 0.5 }),
            verdict,
            mends: vec![Switch { stage: "shading", to: "ratio".to_string(), from: "sampled".to_string() }],
            why: "a < b".to_string(),
            picture: Some("pictures/easy/per-pixel.png".to_string()),
        };
        let row = Row { case: "easy", title: "t", unshadowed: 0.1, cells: vec![cell] };
        whole(&[row], &Provenance::default(), "command")
    }

    #[test]
    fn a_cell_says_what_why_and_what_mends_it() {
        let page = page(Verdict::Wrong(37.2));
        for words in [
            "<td class=\"fails\"",
            "<a href=\"pictures/easy/per-pixel.png\">37</a>",
            "a &lt; b. Mended by shading = ratio",
            "<td>shading: sampled → ratio</td><td>1</td><td>37</td>",
            "0 pass, 0 degraded, 1 fail",
            "<a href=\"pictures/easy/per-pixel.png\">easy</a>",
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
