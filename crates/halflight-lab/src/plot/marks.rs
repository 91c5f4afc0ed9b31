//! Marks of rows: shape by refiner, colour by what varies most, fill by shading.

use halflight_cpu::config::{Named, RefinerConfig, UpsamplerConfig};

use super::chart::{KeyGroup, Mark, Shape};
use crate::results::Finished;

/// Okabe and Ito's colours, told apart by the colour-blind as well.
pub(super) const COLORS: [[u8; 3]; 7] = [
    [0xE6, 0x9F, 0x00],
    [0xCC, 0x79, 0xA7],
    [0xD5, 0x5E, 0x00],
    [0x00, 0x72, 0xB2],
    [0x00, 0x9E, 0x73],
    [0x56, 0xB4, 0xE9],
    [0x99, 0x99, 0x33],
];
const BLACK_INK: [u8; 3] = [0; 3];
const GREY: [u8; 3] = [0x66; 3];
const UPSAMPLERS: &str = "Colour: upsampler";

/// Which mark a row gets: shape by refiner, colour by upsampler (or by light samples or backend, where those vary more),
/// filled for `ratio`.
pub(super) struct Marks {
    refiners: Vec<String>,
    colors: Vec<String>,
    shadings: Vec<String>,
    title: &'static str,
    colored: fn(&Finished) -> String,
}

impl Marks {
    pub(super) fn of(rows: &[&Finished]) -> Self {
        let sampled: fn(&Finished) -> String =
            |row| format!("{} / {}", row.record.pattern, row.record.sharing);
        let upsampled: fn(&Finished) -> String = |row| row.record.upsampler.clone();
        let backend: fn(&Finished) -> String = |row| row.record.visibility.clone();
        // The parameters of `full` are its backend's.
        let set: fn(&Finished) -> String = |row| {
            let full = row.record.refiner == "full";
            let parameters = if full { &row.record.parameters } else { "" };
            format!("{} {parameters}", row.record.visibility).trim_end().to_string()
        };
        let refined = rows.iter().filter(|row| row.record.refiner != "full").copied();
        let all = || rows.iter().copied();
        let (mut title, mut colors, mut colored) = (UPSAMPLERS, distinct(refined, upsampled), upsampled);
        for (other, by) in
            [("Colour: light samples", sampled), ("Colour: backend", backend), ("Colour: backend", set)]
        {
            let found = distinct(all(), by);
            if found.len() > colors.len() && found.len() <= COLORS.len() {
                (title, colors, colored) = (other, found, by);
            }
        }
        let mut refiners = distinct(rows.iter().copied(), |row| row.record.refiner.clone());
        refiners.sort_by_key(|refiner| RefinerConfig::NAMES.iter().position(|known| known == refiner));
        Self {
            refiners,
            colors,
            shadings: distinct(rows.iter().copied(), |row| row.record.shading.clone()),
            title,
            colored,
        }
    }

    pub(super) fn mark(&self, row: &Finished) -> Mark {
        // Monte Carlo has no upsampler to be coloured by.
        let plain = row.record.refiner == "full" && self.title == UPSAMPLERS;
        let rgb = if plain { BLACK_INK } else { self.color(&(self.colored)(row)) };
        Mark { shape: shape(&row.record.refiner), rgb, filled: row.record.shading == "ratio" }
    }

    /// Upsamplers have the same colour in all charts.
    fn color(&self, name: &str) -> [u8; 3] {
        let upsampler = UpsamplerConfig::NAMES.iter().position(|known| *known == name);
        let place = upsampler.or_else(|| self.colors.iter().position(|color| color == name));
        place.map_or(GREY, |place| COLORS[place % COLORS.len()])
    }

    pub(super) fn key(&self) -> Vec<KeyGroup> {
        let group = |title: &str, names: &[String], entry: &dyn Fn(&str) -> (Mark, String)| KeyGroup {
            title: title.to_string(),
            entries: names.iter().map(|name| entry(name)).collect(),
        };
        vec![
            group("Shape: refiner", &self.refiners, &|name| {
                let words = if name == "full" { "full (Monte Carlo)" } else { name };
                (Mark { shape: shape(name), rgb: GREY, filled: true }, words.to_string())
            }),
            group(self.title, &self.colors, &|name| {
                (Mark { shape: Shape::Circle, rgb: self.color(name), filled: true }, name.to_string())
            }),
            group("Fill: shading", &self.shadings, &|name| {
                (Mark { shape: Shape::Circle, rgb: GREY, filled: name == "ratio" }, name.to_string())
            }),
        ]
    }
}

/// A refiner has the same shape in all charts.
fn shape(refiner: &str) -> Shape {
    match RefinerConfig::NAMES.iter().position(|known| *known == refiner) {
        Some(0) => Shape::Circle,
        Some(1) => Shape::Triangle,
        Some(2) => Shape::Square,
        _ => Shape::Diamond,
    }
}

/// Values in the order in which they first occur.
pub(super) fn distinct<'a>(
    rows: impl Iterator<Item = &'a Finished>,
    value: impl Fn(&Finished) -> String,
) -> Vec<String> {
    let mut found = Vec::new();
    for row in rows {
        let value = value(row);
        if !found.contains(&value) {
            found.push(value);
        }
    }
    found
}
