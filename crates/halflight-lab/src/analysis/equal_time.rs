//! Errors of another backend in the same time (Wang17, Table 8).

use super::format::{error, integer, time};
use crate::results::{Finished, Table};

/// Returns the row of `visibility` in the same setting whose frame time is nearest, as a factor; the more accurate one of rows
/// with equal time.
pub fn rival<'a>(rows: &'a [Finished], row: &Finished, visibility: &str) -> Option<&'a Finished> {
    let distance = |other: &Finished| (other.record.total_ms / row.record.total_ms).ln().abs();
    let nearer = |a: &&Finished, b: &&Finished| {
        let by_time = distance(a).total_cmp(&distance(b));
        by_time.then(a.record.nmse2.total_cmp(&b.record.nmse2))
    };
    let rivals = rows.iter().filter(|other| other.setting == row.setting);
    rivals.filter(|other| other.record.visibility == visibility).min_by(nearer)
}

/// Returns a table of every row of another backend, beside its rival.
pub fn table(rows: &[Finished], visibility: &str) -> Table {
    let columns = [
        "row",
        "scene",
        "total ms",
        "NMSE₂",
        "row of nearest time",
        "its light samples",
        "its total ms",
        "its NMSE₂",
        "NMSE₂, its over ours",
    ];
    let others = rows.iter().filter(|row| row.record.visibility != visibility);
    let line = |row: &Finished| {
        let rival = rival(rows, row, visibility)?;
        let (ours, its) = (&row.record, &rival.record);
        Some([
            row.label.clone(),
            ours.scene.clone(),
            time(Some(ours.total_ms)),
            error(Some(ours.nmse2)),
            rival.label.clone(),
            integer(Some(u64::from(its.samples))),
            time(Some(its.total_ms)),
            error(Some(its.nmse2)),
            error((ours.nmse2 > 0.0).then(|| its.nmse2 / ours.nmse2)),
        ])
    };
    Table::new(columns, others.filter_map(line))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::record::tests::finished;

    fn of(visibility: &str, samples: u32, time: f64, error: f64) -> Finished {
        let mut row = finished("per-pixel", "bilinear", time, error);
        row.record.visibility = visibility.to_string();
        row.record.samples = samples;
        row
    }

    #[test]
    fn the_nearest_time_is_found_as_a_factor_and_in_the_same_scene() {
        let mut rows = vec![
            of("raster4d", 1024, 100.0, 1e-5),
            of("bvh", 16, 40.0, 4e-3),
            of("bvh", 36, 210.0, 2e-3), // farther by difference and by factor than the next
            of("bvh", 64, 60.0, 1e-3),
            of("bvh", 49, 60.0, 1.5e-3), // as fast, less accurate
        ];
        let mut elsewhere = of("bvh", 25, 100.0, 1e-2);
        elsewhere.setting = "nave".to_string();
        rows.push(elsewhere);
        assert_eq!(rival(&rows, &rows[0], "bvh").unwrap().record.samples, 64);
        assert!(rival(&rows, &rows[0], "beam").is_none());
        let table = table(&rows, "bvh");
        assert_eq!(table.lines.len(), 1);
        assert_eq!(table.lines[0].cells[5..], ["64", "60.0", "1.00e-3", "100.000"]);
        // By factor 40 is farther from 80 than 150 is.
        rows[0].record.total_ms = 80.0;
        let rows = [rows[0].clone(), rows[1].clone(), of("bvh", 100, 150.0, 1e-3)];
        assert_eq!(rival(&rows, &rows[0], "bvh").unwrap().record.samples, 100);
    }
}
