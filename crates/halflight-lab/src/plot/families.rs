//! Charts of the best of each family: time against a visible error.

use itertools::Itertools as _;

use super::chart::{COLORS, Chart, Mark, Point, Series, Shape};
use super::layout::Layout;
use crate::analysis::families::{Family, families, members, points};
use crate::analysis::{Measure, pareto};
use crate::experiment::quality;
use crate::results::Finished;

/// Returns a chart of the front of each family, with all other rows as dots behind. Qualities of the lattice and light samples
/// of Monte Carlo stand beside their points. `None` where the error was measured of no row.
pub fn chart(title: String, rows: &[&Finished], measure: Measure) -> Option<Chart> {
    let rows: Vec<&Finished> = rows.iter().copied().filter(|row| measure.of(row).is_some()).collect();
    let (mut dots, mut lines, mut entries) = (Vec::new(), Vec::new(), Vec::new());
    for family in families(&rows) {
        let (own, mark) = (members(&rows, &family), mark(&family));
        let places = points(&own, measure);
        let front = pareto::front(&places);
        let point = |index: usize, note: Option<String>| Point {
            note,
            ..Point::new(places[index].0, places[index].1, own[index].label.clone())
        };
        let beaten = (0..places.len()).filter(|index| !front.contains(index));
        dots.push(Series {
            mark: Mark { shape: Shape::Dot, rgb: mark.rgb.map(tint), ..mark },
            points: beaten.map(|index| point(index, None)).collect(),
            connected: false,
        });
        // Backends repeat each other's errors: a word stands at the fastest row.
        let noted = front.iter().unique_by(|&&index| note(own[index]));
        let noted: Vec<usize> = noted.copied().collect();
        let note = |index: usize| note(own[index]).filter(|_| noted.contains(&index));
        lines.push(Series::line(mark, front.iter().map(|&index| point(index, note(index)))));
        entries.push((mark, family.name().to_string()));
    }
    // Lines lie over all dots, and the lattice's over all others.
    let series: Vec<Series> = dots.into_iter().chain(lines.into_iter().rev()).collect();
    let labels = ["time of a frame, ms", measure.label()];
    (!entries.is_empty())
        .then(|| Chart { layout: Layout::COLUMN, ..Chart::new(title, labels, series, ("Family", entries)) })
}

/// Returns the mark of a family, one in all charts.
fn mark(family: &Family) -> Mark {
    let (shape, color) = match family {
        Family::Lattice => (Shape::Diamond, 3),
        Family::Papers => (Shape::Triangle, 2),
        Family::PerPixel => return Mark::filled(Shape::Square, [0; 3]),
        Family::Voxel => (Shape::Circle, 1),
        Family::Rival(name) if name == "pcss" => (Shape::Circle, 4),
        Family::Rival(_) => (Shape::Square, 0),
    };
    Mark::filled(shape, COLORS[color])
}

/// Returns a channel halfway to white.
fn tint(channel: u8) -> u8 {
    channel / 2 + 128
}

/// Returns the word beside a point: its quality, or its light samples.
fn note(row: &Finished) -> Option<String> {
    match (Family::of(&row.record), quality(&row.record.parameters)) {
        (Family::Lattice, Some(quality)) => Some(quality.name().to_string()),
        (Family::PerPixel | Family::Rival(_), _) if row.record.refiner != "pcss" => {
            Some(format!("{} spp", row.record.samples))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::Drawing as _;
    use super::*;
    use crate::results::record::tests::finished;

    #[test]
    fn each_family_has_one_front_and_dots_behind() {
        let mut rows = [
            finished("lattice", "lattice", 10.0, 1e-4),
            finished("nichols", "bilinear", 5.0, 1e-2),
            finished("nichols", "delaunay", 9.0, 1e-2),
            finished("sfvt-gass", "rbf-adaptive", 12.0, 1e-3),
            finished("per-pixel", "bilinear", 30.0, 1e-5),
        ];
        rows[0].record.parameters = "target=0.0001;visible_error=0.04".to_string();
        let chart = chart("A hall".to_string(), &rows.iter().collect::<Vec<_>>(), Measure::FlipP99).unwrap();
        let counts: Vec<(bool, usize)> =
            chart.series.iter().map(|series| (series.connected, series.points.len())).collect();
        assert_eq!(counts, [(false, 0), (false, 1), (false, 0), (true, 1), (true, 2), (true, 1)]);
        let svg = chart.svg().unwrap();
        for words in [
            "A hall",
            "Halflight&apos;s lattice",
            "papers&apos; refiners",
            "good",
            "64 spp",
            "99th percentile",
        ] {
            assert!(svg.contains(words), "{words} is missing in {svg}");
        }
        assert!(svg.contains("width=\"640\""));
    }

    #[test]
    fn rows_without_the_error_make_no_chart() {
        let mut row = finished("lattice", "lattice", 10.0, 1e-4);
        row.record.grain = None;
        assert_eq!(chart("A hall".to_string(), &[&row], Measure::Grain), None);
    }
}
