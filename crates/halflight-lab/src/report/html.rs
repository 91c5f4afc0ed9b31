//! Pieces that pages share: frame, provenance, tables.

use maud::{Markup, PreEscaped, html};

use crate::results::Table;

/// Style of all pages.
const STYLE: &str = include_str!("report.css");

/// Returns a page with a title, with `style` beside that of all pages. It needs no network.
pub fn page(title: &str, style: &str, body: &Markup) -> String {
    let page = html! {
        (PreEscaped("<!doctype html>\n"))
        html lang="en" {
            head {
                meta charset="utf-8";
                title { (title) }
                style { "\n" (PreEscaped(STYLE)) (PreEscaped(style)) }
            }
            body { h1 { (title) } (body) }
        }
    };
    page.into_string()
}

/// Returns a table with the paper's lines set off.
pub fn table(table: &Table, class: Option<&str>) -> Markup {
    html! {
        div.wide {
            table class=[class] {
                thead { tr { @for title in &table.columns { th { (title) } } } }
                tbody {
                    @for line in &table.lines {
                        tr class=[line.from_paper.then_some("paper")] {
                            @for cell in &line.cells { td { (cell) } }
                        }
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::Line;

    #[test]
    fn cells_are_escaped_and_lines_of_papers_are_set_off() {
        let mut lines = Table::new(["name", "ms"], [["a < b", "1.5"].map(str::to_string)]);
        lines.lines.push(Line { from_paper: true, cells: vec!["theirs, all".to_string(), String::new()] });
        let html = table(&lines, None).into_string();
        for piece in
            ["<th>ms</th>", "<td>a &lt; b</td><td>1.5</td>", "<tr class=\"paper\"><td>theirs, all</td>"]
        {
            assert!(html.contains(piece), "{piece} is missing in {html}");
        }
    }
}
