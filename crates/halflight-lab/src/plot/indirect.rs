//! Charts of indirect light: error against time.

use super::chart::{Chart, Mark, Point, Series};
use crate::results::IndirectRow;

/// Returns a chart of the relative error against the time of the indirect stage, a mark a row; rows without an error above the reference's noise are left
/// out. `None` where no row is left.
pub fn chart(title: String, rows: &[&IndirectRow]) -> Option<Chart> {
    let shown = rows.iter().filter(|row| row.relative_error() > 0.0).enumerate();
    let one = |(place, row): (usize, &&IndirectRow)| {
        let mark = Mark::nth(place);
        let point = Point::new(row.indirect_ms, row.relative_error(), row.label.clone());
        (Series { mark, points: vec![point], connected: false }, (mark, row.label.clone()))
    };
    let (series, entries): (Vec<_>, Vec<_>) = shown.map(one).unzip();
    let labels = ["time of the indirect stage, ms", "relative error of the luminance"];
    let noise = rows.iter().map(|row| row.reference_noise.sqrt()).fold(0.0, f64::max);
    let chart = Chart::new(title, labels, series, ("Method", entries));
    let noise = (noise > 0.0).then_some(noise);
    (!chart.series.is_empty()).then_some(Chart { noise, pareto: true, ..chart })
}

#[cfg(test)]
mod tests {
    use super::super::Drawing as _;
    use super::*;
    use crate::results::indirect::tests::row;

    #[test]
    fn every_row_above_the_noise_has_a_mark() {
        let rows = [row("lpv", 10.0, 0.09), row("gather", 40.0, 1e-3), row("exact", 90.0, 1e-5)];
        let chart = chart("Hall".to_string(), &rows.iter().collect::<Vec<_>>()).unwrap();
        let places: Vec<f64> = chart.series.iter().map(|series| series.points[0].x).collect();
        assert_eq!(places, [10.0, 40.0]);
        assert_eq!(chart.front().len(), 2);
        let svg = chart.svg().unwrap();
        assert!(svg.contains("gather") && svg.contains("time of the indirect stage"), "{svg}");
        assert_eq!(super::chart("Hall".to_string(), &[]), None);
    }
}
