//! Pieces of pages: style, escaping, tables.

use crate::results::{Line, Table};

/// Style of all pages.
pub const STYLE: &str = include_str!("report.css");

/// Returns a table as HTML, with the paper's lines set off.
pub fn table(table: &Table) -> String {
    let cells = |tag: &str, texts: &[String]| -> String {
        texts.iter().map(|text| format!("<{tag}>{}</{tag}>", escape(text))).collect()
    };
    let line = |line: &Line| {
        let class = if line.from_paper { " class=\"paper\"" } else { "" };
        format!("<tr{class}>{}</tr>\n", cells("td", &line.cells))
    };
    format!(
        "<div class=\"wide\"><table><thead><tr>{}</tr></thead><tbody>\n{}</tbody></table></div>\n",
        cells("th", &table.columns),
        table.lines.iter().map(line).collect::<String>()
    )
}

/// Text for HTML, in and between tags.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_escaped_and_lines_of_papers_are_set_off() {
        let mut lines = Table::new(["name", "ms"], [["a < b", "1.5"].map(str::to_string)]);
        lines.lines.push(Line { from_paper: true, cells: vec!["theirs, all".to_string(), String::new()] });
        let html = table(&lines);
        for piece in
            ["<th>ms</th>", "<td>a &lt; b</td><td>1.5</td>", "<tr class=\"paper\"><td>theirs, all</td>"]
        {
            assert!(html.contains(piece), "{piece} is missing in {html}");
        }
    }
}
