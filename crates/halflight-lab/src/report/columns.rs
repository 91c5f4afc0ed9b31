//! Columns of the report's tables of rows.

use crate::analysis::format::{error, integer, time};
use crate::results::Finished;

/// Title of a column and its text in a row. The column is left out where all texts are empty.
pub(super) type Column = (&'static str, fn(&Finished) -> String);

pub(super) const COLUMNS: [Column; 43] = [
    ("refiner", |row| row.record.refiner.clone()),
    ("visibility", |row| row.record.visibility.clone()),
    ("parameters", |row| row.record.parameters.clone()),
    ("upsampler", |row| row.record.upsampler.clone()),
    ("shading", |row| row.record.shading.clone()),
    ("samples", |row| row.record.samples.to_string()),
    ("pattern", |row| format!("{} / {}", row.record.pattern, row.record.sharing)),
    ("fragments", |row| integer(Some(row.record.fragments))),
    ("rays", |row| integer(Some(row.record.rays))),
    ("G-buffer ms", |row| time(Some(row.record.gbuffer_ms))),
    ("pyramid ms", |row| time(Some(row.record.pyramid_ms))),
    ("refine ms", |row| time(Some(row.record.refine_ms))),
    ("visibility ms", |row| time(Some(row.record.visibility_ms))),
    ("Mrays/s", |row| per_second(row.record.rays, row.record.visibility_ms)),
    ("of it preparation", |row| time(Some(row.record.prepare_ms))),
    ("irradiance ms", |row| time(Some(row.record.irradiance_ms))),
    ("upsample ms", |row| time(Some(row.record.upsample_ms))),
    ("compose ms", |row| time(Some(row.record.compose_ms))),
    ("total ms", |row| time(Some(row.record.total_ms))),
    ("NMSE₂", |row| {
        let mark = if row.record.near_noise() { " ‡" } else { "" };
        format!("{}{mark}", error(Some(row.record.nmse2)))
    }),
    ("NMSE", |row| error(Some(row.record.nmse))),
    ("relMSE", |row| error(Some(row.record.relmse))),
    ("SSIM", |row| format!("{:.4}", row.record.ssim)),
    ("ꟻLIP", |row| format!("{:.4}", row.record.flip)),
    ("ꟻLIP, 99 %", |row| contrast(row.record.flip_p99)),
    ("grain", |row| contrast(row.record.grain)),
    ("off %", |row| percent(row.record.off_share)),
    ("false shadow %", |row| percent(row.record.false_shadow)),
    ("false light %", |row| percent(row.record.false_light)),
    ("off by itself", |row| integer(row.record.self_occlusion)),
    ("by thin geometry", |row| integer(row.record.thickness)),
    ("by what is out of view", |row| integer(row.record.out_of_view)),
    ("by what was missed", |row| integer(row.record.missed)),
    ("flicker, mean", |row| error(row.record.flicker_mean)),
    ("flicker, 99 %", |row| error(row.record.flicker_p99)),
    ("NMSE₂ of frames", |row| error(row.record.flicker_nmse2)),
    ("certified lit", |row| counted(row.record.lit)),
    ("certified umbra", |row| counted(row.record.umbra)),
    ("from shared lists", |row| counted(row.record.listed)),
    ("left to rays", |row| counted(row.record.left_to_rays)),
    ("pairs", |row| counted(row.record.pairs)),
    ("pairs kept", |row| counted(row.record.kept)),
    ("pairs relevant", |row| counted(row.record.relevant)),
];

/// Returns millions a second.
fn per_second(count: u64, ms: f64) -> String {
    if ms > 0.0 { format!("{:.1}", count as f64 / ms * 1e-3) } else { String::new() }
}

/// Returns a perceptual error, or a dash where it was not measured.
fn contrast(value: Option<f64>) -> String {
    value.map_or("–".to_string(), |value| format!("{value:.4}"))
}

/// Returns a share in percent.
fn percent(share: Option<f64>) -> String {
    share.map_or(String::new(), |share| format!("{:.2}", share * 100.0))
}

/// Returns a count, or nothing for a backend that has no notion of it.
fn counted(count: u64) -> String {
    integer((count > 0).then_some(count))
}
