//! Work of rows along an animation, level by level.

use crate::results::{Finished, Table};

/// Returns the number of all cells of a level of an image.
pub fn cells([width, height]: [u32; 2], level: usize) -> u64 {
    let across = |size: u32| u64::from(size).div_ceil(1 << level.min(31));
    across(width) * across(height)
}

/// Returns a table with a line for each level of each frame of each row, the coarsest first.
pub fn table(rows: &[Finished]) -> Table {
    let lines = rows.iter().flat_map(|row| {
        let record = &row.record;
        let size = [record.width, record.height];
        row.path.iter().enumerate().flat_map(move |(number, frame)| {
            frame.levels.iter().enumerate().rev().map(move |(level, work)| {
                let all = cells(size, level);
                [
                    record.scene.clone(),
                    row.label.clone(),
                    number.to_string(),
                    frame.time_s.to_string(),
                    format!("{}x{}", size[0].div_ceil(1 << level), size[1].div_ceil(1 << level)),
                    all.to_string(),
                    work.rendered.to_string(),
                    format!("{:.2}", 100.0 * work.rendered as f64 / all as f64),
                    format!("{:.3}", work.ms),
                    format!("{:.3}", frame.total_ms),
                    record.commit.clone(),
                    record.machine.clone(),
                ]
            })
        })
    });
    let columns = [
        "scene",
        "row",
        "frame",
        "time_s",
        "resolution",
        "fragments",
        "rendered",
        "rendered_percent",
        "level_ms",
        "total_ms",
        "commit",
        "machine",
    ];
    Table::new(columns, lines)
}

#[cfg(test)]
mod tests {
    use halflight_core::stats::LevelWork;

    use super::*;
    use crate::results::FrameWork;
    use crate::results::record::tests::finished;

    #[test]
    fn levels_are_lines() {
        let mut row = finished("nichols", "bilinear", 3.0, 1e-3);
        let levels = vec![LevelWork { rendered: 768, ms: 2.0 }, LevelWork { rendered: 768, ms: 1.0 }];
        row.path = vec![FrameWork { time_s: 0.5, levels, total_ms: 4.0 }];
        let table = table(&[row]);
        // Of 64 × 48 pixels, and of a quarter of them.
        let shares: Vec<&str> = table.lines.iter().map(|line| line.cells[7].as_str()).collect();
        let sizes: Vec<&str> = table.lines.iter().map(|line| line.cells[4].as_str()).collect();
        assert_eq!((shares, sizes), (vec!["100.00", "25.00"], vec!["32x24", "64x48"]));
    }
}
