//! A paper's figures with ours below them.

use super::experiment::{Paper, PaperRow};
use super::record::Finished;

/// Titles of the columns.
pub const COLUMNS: [&str; 12] = [
    "row",
    "scene",
    "triangles",
    "fragments",
    "rays",
    "visibility ms",
    "upsampling ms",
    "total ms",
    "SSE",
    "NMSE",
    "SSE, paper's kind of reference",
    "NMSE, paper's kind of reference",
];

/// A line of the table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// Whether the paper says it, or we.
    pub from_paper: bool,
    /// One text a column; empty where there is no figure.
    pub cells: [String; COLUMNS.len()],
}

/// The paper's rows, each followed by those of ours that stand for it. Its errors are against its own kind of reference.
pub fn lines(paper: &Paper, rows: &[Finished]) -> Vec<Line> {
    let mut lines = Vec::new();
    for theirs in &paper.rows {
        lines.push(Line {
            from_paper: true,
            cells: [
                format!("{}: {}", paper.source, theirs.label),
                String::new(),
                integer(theirs.triangles),
                integer(theirs.fragments),
                integer(theirs.rays),
                time(theirs.visibility_ms),
                time(theirs.upsample_ms),
                time(theirs.total_ms),
                String::new(),
                String::new(),
                error(theirs.sse),
                error(theirs.nmse),
            ],
        });
        lines.extend(rows.iter().filter(|row| stands_for(row, theirs)).map(ours));
    }
    lines
}

fn stands_for(row: &Finished, theirs: &PaperRow) -> bool {
    let record = &row.record;
    let scene = record.scene.split(' ').next() == Some(theirs.scene.as_str());
    let is = |wanted: &Option<String>, have: &str| wanted.as_deref().is_none_or(|wanted| wanted == have);
    scene
        && record.refiner == theirs.refiner
        && is(&theirs.visibility, &record.visibility)
        && is(&theirs.parameters, &record.parameters)
        && theirs.samples.is_none_or(|samples| samples == record.samples)
        && is(&theirs.upsampler, &record.upsampler)
        && is(&theirs.shading, &record.shading)
        && theirs.light_scale.is_none_or(|scale| scale == record.light_scale)
}

fn ours(row: &Finished) -> Line {
    let record = &row.record;
    Line {
        from_paper: false,
        cells: [
            row.label.clone(),
            record.scene.clone(),
            integer(Some(record.triangles)),
            integer(Some(record.fragments)),
            integer(Some(record.rays)),
            time(Some(record.visibility_ms)),
            time(Some(record.upsample_ms)),
            time(Some(record.total_ms)),
            error(Some(row.normalised_sse)),
            error(Some(record.nmse)),
            error(row.paper.map(|paper| paper.sse)),
            error(row.paper.map(|paper| paper.nmse)),
        ],
    }
}

/// Digits in groups of three.
pub(crate) fn integer(value: Option<u64>) -> String {
    let digits = value.map_or(String::new(), |value| value.to_string());
    let mut grouped = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}

pub(crate) fn time(value: Option<f64>) -> String {
    value.map_or(
        String::new(),
        |value| if value < 10.0 { format!("{value:.2}") } else { format!("{value:.1}") },
    )
}

pub(crate) fn error(value: Option<f64>) -> String {
    value.map_or(String::new(), |value| {
        if value == 0.0 || (0.01..1e4).contains(&value) {
            format!("{value:.3}")
        } else {
            format!("{value:.2e}")
        }
    })
}

#[cfg(test)]
mod tests {
    use super::super::Experiment;
    use super::super::record::tests::finished;
    use super::*;

    #[test]
    fn ours_stand_below_theirs() {
        let paper = Experiment::resolve("koa-table1").unwrap().paper.unwrap();
        let mut ours = finished("nichols", "bilinear", 80.0, 3e-3);
        ours.record.scene = "hairball triangles=2850000".to_string();
        let lines = lines(&paper, &[ours]);
        assert_eq!(lines.len(), 9 + 1);
        let place = lines.iter().position(|line| !line.from_paper).unwrap();
        assert!(lines[place - 1].cells[0].contains("14b") && lines[place - 1].cells[4] == "5,450,000");
        assert_eq!(lines[place].cells[7], "80.0");
    }

    #[test]
    fn figures_are_grouped_and_short() {
        assert_eq!([0, 999, 1000, 1234567].map(|n| integer(Some(n))), ["0", "999", "1,000", "1,234,567"]);
        assert_eq!([5.42e-4, 1.112, 1473.0].map(|n| error(Some(n))), ["5.42e-4", "1.112", "1473.000"]);
    }
}
