//! Summaries of the rows of a setting in words.

use indexmap::IndexMap;
use itertools::Itertools as _;

use super::pareto;
use crate::results::record::NOISE_MARGIN;
use crate::results::{Finished, Record};

/// NMSE₂ that a picture should reach.
const GOAL: f64 = 4e-4;

/// Returns a few sentences about one setting.
pub fn sentences(rows: &[&Finished]) -> Vec<String> {
    let mut sentences = Vec::new();
    sentences.push(front(
        "time",
        rows,
        |row| row.record.total_ms,
        |row| format!("{:.0} ms", row.record.total_ms),
    ));
    sentences.push(front("rays", rows, |row| row.record.rays as f64, rays));
    sentences.extend(goal(rows));
    sentences.extend(upsamplers(rows));
    let noisy = rows.iter().filter(|row| row.record.near_noise()).count();
    if noisy > 0 {
        sentences.push(format!(
            "{noisy} of {} rows have an error less than {NOISE_MARGIN:.0} times the reference's own (marked ‡): their errors are upper \
             bounds, and their order among themselves means little.",
            rows.len()
        ));
    }
    sentences
}

fn rays(row: &Finished) -> String {
    format!("{:.2} M rays", row.record.rays as f64 / 1e6)
}

fn front(
    what: &str,
    rows: &[&Finished],
    cost: impl Fn(&Finished) -> f64,
    words: impl Fn(&Finished) -> String,
) -> String {
    let points: Vec<(f64, f64)> = rows.iter().map(|row| (cost(row), row.record.nmse2)).collect();
    let members = pareto::front(&points).into_iter().map(|index| {
        let row = rows[index];
        format!("{} ({}, {:.2e})", row.label, words(row), row.record.nmse2)
    });
    let members = members.into_iter().join("; ");
    format!("On the Pareto front of {what} and NMSE₂, from cheap to accurate: {members}.")
}

/// Returns which rows reach the goal in least time and with fewest rays, beside Monte Carlo with the most samples.
fn goal(rows: &[&Finished]) -> Vec<String> {
    let per_pixel =
        rows.iter().filter(|row| row.record.refiner == "per-pixel" && row.record.visibility == "bvh");
    let per_pixel = per_pixel.max_by_key(|row| row.record.samples);
    let reached: Vec<&&Finished> =
        rows.iter().filter(|row| row.record.refiner != "per-pixel" && row.record.nmse2 <= GOAL).collect();
    let Some(fastest) = reached.iter().min_by(|a, b| a.record.total_ms.total_cmp(&b.record.total_ms)) else {
        let best = rows.iter().filter(|row| row.record.refiner != "per-pixel");
        let best = best.min_by(|a, b| a.record.nmse2.total_cmp(&b.record.nmse2));
        let words = |best: &&Finished| {
            let (label, nmse2) = (&best.label, best.record.nmse2);
            format!("No refiner reaches NMSE₂ ≤ {GOAL:.0e}; the closest is {label} with {nmse2:.2e}.")
        };
        return best.map(words).into_iter().collect();
    };
    let share = |row: &Finished| match per_pixel {
        Some(per_pixel) if per_pixel.record.rays > 0 => {
            format!(
                ", {:.0} % of the rays and {:.0} % of the time of per-pixel with {} samples",
                100.0 * row.record.rays as f64 / per_pixel.record.rays as f64,
                100.0 * row.record.total_ms / per_pixel.record.total_ms,
                per_pixel.record.samples
            )
        }
        _ => String::new(),
    };
    let told = |row: &Finished| {
        format!("{}: {:.1} ms, {}{}.", row.label, row.record.total_ms, rays(row), share(row))
    };
    let mut sentences = vec![format!("The fastest refiner with NMSE₂ ≤ {GOAL:.0e} is {}", told(fastest))];
    if let Some(fewest) = reached.iter().min_by_key(|row| row.record.rays)
        && fewest.record.rays < fastest.record.rays
    {
        sentences.push(format!("The one with the fewest rays is {}", told(fewest)));
    }
    sentences
}

/// Returns the upsamplers by accuracy for each set of fragments that was given to several.
fn upsamplers(rows: &[&Finished]) -> Vec<String> {
    let mut groups: IndexMap<(&str, &str), Vec<&Record>> = IndexMap::new();
    for row in rows {
        groups.entry((&row.fragments, &row.record.shading)).or_default().push(&row.record);
    }
    let sentence = |((_, shading), mut same): ((&str, &str), Vec<&Record>)| {
        let Record { refiner, parameters, .. } = same[0];
        let parameters = if parameters.is_empty() { String::new() } else { format!(" ({parameters})") };
        same.sort_by(|a, b| a.nmse2.total_cmp(&b.nmse2));
        let order = same
            .iter()
            .format_with(" < ", |record, f| f(&format_args!("{} {:.2e}", record.upsampler, record.nmse2)));
        format!("Upsamplers on the fragments of {refiner}{parameters}, {shading}, by NMSE₂: {order}.")
    };
    groups.into_iter().filter(|(_, same)| same.len() > 1).map(sentence).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::record::tests::finished;

    #[test]
    fn it_names_the_front_the_goal_and_the_order_of_upsamplers() {
        let rows = [
            finished("nichols", "bilinear", 10.0, 1e-2),
            finished("nichols", "delaunay", 12.0, 3e-4),
            finished("sfvt-gass", "delaunay", 20.0, 2e-4),
            finished("per-pixel", "bilinear", 100.0, 1e-6),
        ];
        let text = sentences(&rows.iter().collect::<Vec<_>>()).join("\n");
        assert!(text.contains("nichols · bilinear · ratio (10 ms, 1.00e-2); nichols · delaunay"), "{text}");
        assert!(
            text.contains("≤ 4e-4 is nichols · delaunay · ratio: 12.0 ms, 0.01 M rays, 12 % of the rays"),
            "{text}"
        );
        assert!(text.contains("of nichols, ratio, by NMSE₂: delaunay 3.00e-4 < bilinear 1.00e-2"), "{text}");
        assert!(text.contains("1 of 4 rows"), "{text}");
    }

    #[test]
    fn it_says_when_no_one_is_accurate_enough() {
        let rows = [finished("nichols", "bilinear", 10.0, 1e-2)];
        let text = sentences(&rows.iter().collect::<Vec<_>>()).join("\n");
        assert!(text.contains("No refiner reaches NMSE₂ ≤ 4e-4"), "{text}");
    }
}
