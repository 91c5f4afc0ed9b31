//! Figures of a paper with ours below them.

use super::equal_time::rival;
use super::format::{error, integer, time};
use crate::experiment::{Paper, PaperRow};
use crate::results::{Finished, Line, Table};

/// Column with the paper's figures and ours.
struct Column {
    title: &'static str,
    /// Set to leave the column out where the paper's rows have no figure for it.
    optional: bool,
    theirs: fn(&Paper, &PaperRow) -> String,
    ours: fn(&Finished, &[Finished]) -> String,
}

const fn always(
    title: &'static str,
    theirs: fn(&Paper, &PaperRow) -> String,
    ours: fn(&Finished, &[Finished]) -> String,
) -> Column {
    Column { title, optional: false, theirs, ours }
}

const fn where_given(
    title: &'static str,
    theirs: fn(&Paper, &PaperRow) -> String,
    ours: fn(&Finished, &[Finished]) -> String,
) -> Column {
    Column { title, optional: true, theirs, ours }
}

/// All columns. The paper's errors are against its own kind of reference.
const COLUMNS: [Column; 18] = [
    always("row", |paper, row| format!("{}: {}", paper.source, row.label), |row, _| row.label.clone()),
    always("scene", |_, _| String::new(), |row, _| row.record.scene.clone()),
    always("triangles", |_, row| integer(row.triangles), |row, _| integer(Some(row.record.triangles))),
    always("fragments", |_, row| integer(row.fragments), |row, _| integer(Some(row.record.fragments))),
    always("rays", |_, row| integer(row.rays), |row, _| integer(Some(row.record.rays))),
    where_given("preparation ms", |_, row| time(row.prepare_ms), |row, _| time(Some(row.record.prepare_ms))),
    where_given(
        "masks ms",
        |_, row| time(row.masks_ms),
        |row, _| time(Some(row.record.visibility_ms - row.record.prepare_ms)),
    ),
    always("visibility ms", |_, row| time(row.visibility_ms), |row, _| time(Some(row.record.visibility_ms))),
    where_given(
        "irradiance ms",
        |_, row| time(row.irradiance_ms),
        |row, _| time(Some(row.record.irradiance_ms)),
    ),
    always("upsampling ms", |_, row| time(row.upsample_ms), |row, _| time(Some(row.record.upsample_ms))),
    always("total ms", |_, row| time(row.total_ms), |row, _| time(Some(row.record.total_ms))),
    where_given(
        "relevant pairs, %",
        |_, row| percent(row.relevant_before),
        |row, _| percent(share(row.record.relevant, row.record.pairs)),
    ),
    where_given(
        "relevant pairs after rejection, %",
        |_, row| percent(row.relevant_after),
        |row, _| percent(share(row.record.relevant, row.record.kept)),
    ),
    where_given(
        "light samples of ray tracing in the same time",
        |_, row| integer(row.equal_time_samples.map(u64::from)),
        |row, rows| integer(rival(rows, row, "bvh").map(|rival| u64::from(rival.record.samples))),
    ),
    always("SSE", |_, _| String::new(), |row, _| error(Some(row.normalised_sse))),
    always("NMSE", |_, _| String::new(), |row, _| error(Some(row.record.nmse))),
    always(
        "SSE, paper's kind of reference",
        |_, row| error(row.sse),
        |row, _| error(row.paper.map(|paper| paper.sse)),
    ),
    always(
        "NMSE, paper's kind of reference",
        |_, row| error(row.nmse),
        |row, _| error(row.paper.map(|paper| paper.nmse)),
    ),
];

/// Returns the paper's rows, each followed by those of ours that stand for it.
pub fn table(paper: &Paper, rows: &[Finished]) -> Table {
    let given = |column: &Column| paper.rows.iter().any(|theirs| !(column.theirs)(paper, theirs).is_empty());
    let columns: Vec<Column> =
        COLUMNS.into_iter().filter(|column| !column.optional || given(column)).collect();
    let mut table =
        Table { columns: columns.iter().map(|column| column.title.to_string()).collect(), lines: Vec::new() };
    for theirs in &paper.rows {
        let cells = columns.iter().map(|column| (column.theirs)(paper, theirs));
        table.lines.push(Line { from_paper: true, cells: cells.collect() });
        for row in rows.iter().filter(|row| stands_for(row, theirs)) {
            let cells = columns.iter().map(|column| (column.ours)(row, rows));
            table.lines.push(Line { from_paper: false, cells: cells.collect() });
        }
    }
    table
}

fn stands_for(row: &Finished, theirs: &PaperRow) -> bool {
    let record = &row.record;
    let is = |wanted: &Option<String>, have: &str| wanted.as_deref().is_none_or(|wanted| wanted == have);
    record.scene_name() == theirs.scene
        && record.refiner == theirs.refiner
        && is(&theirs.visibility, &record.visibility)
        && is(&theirs.parameters, &record.parameters)
        && theirs.samples.is_none_or(|samples| samples == record.samples)
        && is(&theirs.upsampler, &record.upsampler)
        && is(&theirs.shading, &record.shading)
        && theirs.light_scale.is_none_or(|scale| scale == record.light_scale)
}

/// Returns percent of a whole, if that was counted.
fn share(part: u64, whole: u64) -> Option<f64> {
    (part > 0 && whole > 0).then(|| 100.0 * part as f64 / whole as f64)
}

fn percent(value: Option<f64>) -> String {
    value.map_or(String::new(), |value| format!("{value:.1}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Experiment;
    use crate::results::record::tests::finished;

    #[test]
    fn ours_stand_below_theirs() {
        let paper = Experiment::resolve("koa-table1").unwrap().paper.unwrap();
        let mut ours = finished("nichols", "bilinear", 80.0, 3e-3);
        ours.record.scene = "hairball triangles=2850000".to_string();
        let table = table(&paper, &[ours]);
        let lines = &table.lines;
        assert_eq!((lines.len(), table.columns.len()), (9 + 1, 12));
        let place = lines.iter().position(|line| !line.from_paper).unwrap();
        assert!(lines[place - 1].cells[0].contains("14b") && lines[place - 1].cells[4] == "5,450,000");
        assert_eq!(lines[place].cells[7], "80.0");
    }

    #[test]
    fn columns_without_a_figure_of_the_paper_s_can_be_left_out() {
        let paper = Experiment::resolve("wang-table3").unwrap().paper.unwrap();
        let mut ours = finished("per-pixel", "bilinear", 80.0, 3e-3);
        (ours.record.scene, ours.record.visibility) = ("tower".to_string(), "raster4d".to_string());
        let table = table(&paper, &[ours]);
        let place = table.columns.iter().position(|column| column == "masks ms").unwrap();
        assert!(!table.columns.iter().any(|column| column.contains("same time")));
        let tower = table.lines.iter().position(|line| !line.from_paper).unwrap();
        assert_eq!(table.lines[tower - 1].cells[place - 1..=place], ["16.0", "72.0"]);
        assert_eq!(table.lines[tower].cells[place - 1..=place], ["0.25", "0.45"]);
    }

    #[test]
    fn relevant_pairs_are_shares_of_those_looked_at() {
        let paper = Experiment::resolve("wang-table7").unwrap().paper.unwrap();
        let mut ours = finished("per-pixel", "bilinear", 80.0, 3e-3);
        (ours.record.scene, ours.record.visibility) = ("church".to_string(), "raster4d".to_string());
        let table = table(&paper, &[ours]);
        let place = table.columns.iter().position(|column| column == "relevant pairs, %").unwrap();
        let church = table.lines.iter().position(|line| !line.from_paper).unwrap();
        assert_eq!(table.lines[church - 1].cells[place..place + 2], ["10.0", "37.0"]);
        assert_eq!(table.lines[church].cells[place..place + 2], ["12.5", "25.0"]);
    }
}
