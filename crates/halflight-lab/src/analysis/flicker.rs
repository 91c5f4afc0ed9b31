//! Tables of flicker.

use crate::results::{Finished, Table};

/// Returns a table with a line for each frame of each row.
pub fn table(rows: &[Finished]) -> Table {
    let text = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.6e}"));
    let lines = rows.iter().flat_map(|row| {
        row.frames.iter().enumerate().map(move |(number, frame)| {
            let flicker = frame.flicker;
            [
                row.record.scene.clone(),
                row.label.clone(),
                number.to_string(),
                frame.time_s.to_string(),
                text(Some(frame.nmse2)),
                text(flicker.map(|flicker| flicker.mean)),
                text(flicker.map(|flicker| flicker.p99)),
                text(Some(frame.noise)),
            ]
        })
    });
    let columns =
        ["scene", "row", "frame", "time_s", "nmse2", "flicker_mean", "flicker_p99", "reference_flicker"];
    Table::new(columns, lines)
}
