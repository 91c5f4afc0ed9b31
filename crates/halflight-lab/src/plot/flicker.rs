//! Bars of flicker.

use super::bars::{Bar, Bars};
use super::marks::Marks;
use crate::results::{Finished, Means};

/// Returns bars for the rows of a setting, the steadiest first.
pub fn bars(title: String, rows: &[&Finished]) -> Bars {
    let marks = Marks::of(rows);
    let mut noise = 0.0;
    let mut bars: Vec<Bar> = Vec::new();
    for row in rows {
        let Some(means) = Means::of(&row.frames) else { continue };
        noise = means.noise.max(noise);
        bars.push(Bar { name: row.label.clone(), values: [means.mean, means.p99], rgb: marks.mark(row).rgb });
    }
    bars.sort_by(|a, b| a.values[0].total_cmp(&b.values[0]));
    Bars {
        title,
        quantities: ["mean".to_string(), "99th percentile".to_string()],
        unit: "|Δ frame − Δ reference| over the reference's mean, luminance".to_string(),
        note: format!("The reference's own noise makes at most about {noise:.1e} of each mean."),
        bars,
    }
}
