//! Work of rows along an animation: lines by level.

use super::chart::{COLORS, Chart, Mark, Point, Scale, Series, Shape};
use crate::analysis::path::cells;
use crate::results::Finished;

/// Quantity of a chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Rendered fragments of a level, percent of all that it has.
    Share,
    /// Time of a level, and of the whole frame.
    Time,
}

/// Returns a chart of a quantity against the time in the animation: a colour a level, a shape a row. `None` where no row tells its work.
pub fn chart(title: String, rows: &[&Finished], quantity: Quantity) -> Option<Chart> {
    let told = rows.iter().filter(|row| row.path.iter().any(|frame| !frame.levels.is_empty()));
    let (mut series, mut entries) = (Vec::new(), Vec::new());
    for (number, row) in told.enumerate() {
        let size = [row.record.width, row.record.height];
        let mut add = |place: usize, words: String, value: &dyn Fn(usize) -> f64| {
            let mark = Mark::filled(Shape::nth(number), COLORS[place % COLORS.len()]);
            let points = (0..row.path.len())
                .map(|frame| Point::new(row.path[frame].time_s, value(frame), words.clone()));
            series.push(Series::line(mark, points));
            entries.push((mark, format!("{}, {words}", row.label)));
        };
        let levels = row.path.iter().map(|frame| frame.levels.len()).max().unwrap_or(0);
        for level in (0..levels).rev() {
            let work = |frame: usize| row.path[frame].levels.get(level).copied().unwrap_or_default();
            let [width, height] = size.map(|size| size.div_ceil(1 << level));
            let value = |frame: usize| match quantity {
                Quantity::Share => 100.0 * work(frame).rendered as f64 / cells(size, level) as f64,
                Quantity::Time => work(frame).ms,
            };
            add(level, format!("{width} × {height}"), &value);
        }
        if quantity == Quantity::Time {
            add(levels, "whole frame".to_string(), &|frame| row.path[frame].total_ms);
        }
    }
    if series.is_empty() {
        return None;
    }
    let y_label = match quantity {
        Quantity::Share => "rendered fragments, % of those of the level",
        Quantity::Time => "time of the level, ms",
    };
    let mut chart = Chart::new(title, ["time in the animation, s", y_label], series, ("Level", entries));
    chart.x_scale = Scale::Linear;
    Some(chart)
}

#[cfg(test)]
mod tests {
    use halflight_core::stats::LevelWork;

    use super::super::Drawing as _;
    use super::*;
    use crate::results::FrameWork;
    use crate::results::record::tests::finished;

    #[test]
    fn every_level_has_a_line() {
        let mut row = finished("nichols", "bilinear", 3.0, 1e-3);
        assert_eq!(chart("t".to_string(), &[&row], Quantity::Share), None);
        let levels = vec![LevelWork { rendered: 1536, ms: 2.0 }; 2];
        row.path =
            [0.0, 0.5].map(|time_s| FrameWork { time_s, levels: levels.clone(), total_ms: 5.0 }).to_vec();
        let share = chart("t".to_string(), &[&row], Quantity::Share).unwrap();
        let ys: Vec<f64> = share.series.iter().map(|series| series.points[1].y).collect();
        assert_eq!(ys, [200.0, 50.0]);
        let time = chart("t".to_string(), &[&row], Quantity::Time).unwrap();
        assert_eq!(time.series.len(), 3);
        assert!(time.svg().unwrap().contains("whole frame"));
    }
}
