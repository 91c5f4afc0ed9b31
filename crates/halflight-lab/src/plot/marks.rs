//! Marks of rows: shape by refiner, colour by what varies most, fill by shading.

use halflight_cpu::config::{Named, RefinerConfig, UpsamplerConfig};
use itertools::Itertools as _;

use super::chart::{COLORS, KeyGroup, Mark, Shape};
use crate::results::Finished;
use crate::rivals::Rival;

const BLACK_INK: [u8; 3] = [0; 3];
const GREY: [u8; 3] = [0x66; 3];
const UPSAMPLERS: &str = "Colour: upsampler";

/// Choice of marks for rows: shape by refiner, colour by upsampler (or by light samples or backend, where those vary more),
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
        // The parameters of `per-pixel` are its backend's.
        let set: fn(&Finished) -> String = |row| {
            let per_pixel = row.record.refiner == "per-pixel";
            let parameters = if per_pixel { &row.record.parameters } else { "" };
            format!("{} {parameters}", row.record.visibility).trim_end().to_string()
        };
        let distinct =
            |by: fn(&Finished) -> String| -> Vec<String> { rows.iter().copied().map(by).unique().collect() };
        let refined = rows.iter().copied().filter(|row| row.record.refiner != "per-pixel");
        let upsamplers: Vec<String> = refined.map(upsampled).unique().collect();
        let (mut title, mut colors, mut colored) = (UPSAMPLERS, upsamplers, upsampled);
        for (other, by) in
            [("Colour: light samples", sampled), ("Colour: backend", backend), ("Colour: backend", set)]
        {
            let found = distinct(by);
            if found.len() > colors.len() && found.len() <= COLORS.len() {
                (title, colors, colored) = (other, found, by);
            }
        }
        let mut refiners = distinct(|row| row.record.refiner.clone());
        refiners.sort_by_key(|refiner| place(refiner));
        Self { refiners, colors, shadings: distinct(|row| row.record.shading.clone()), title, colored }
    }

    pub(super) fn mark(&self, row: &Finished) -> Mark {
        // Monte Carlo has no upsampler to be coloured by.
        let plain = row.record.refiner == "per-pixel" && self.title == UPSAMPLERS;
        let rgb = if plain { BLACK_INK } else { self.color(&(self.colored)(row)) };
        Mark { shape: shape(&row.record.refiner), rgb, filled: row.record.shading == "ratio" }
    }

    /// Returns a colour; an upsampler has one colour in all charts.
    fn color(&self, name: &str) -> [u8; 3] {
        let mut known = UpsamplerConfig::NAMES.iter().chain(&Rival::UPSAMPLERS);
        let upsampler = known.position(|known| *known == name);
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
                let words = if name == "per-pixel" { "per-pixel (Monte Carlo)" } else { name };
                (Mark::filled(shape(name), GREY), words.to_string())
            }),
            group(self.title, &self.colors, &|name| {
                (Mark::filled(Shape::Circle, self.color(name)), name.to_string())
            }),
            group("Fill: shading", &self.shadings, &|name| {
                (Mark { shape: Shape::Circle, rgb: GREY, filled: name == "ratio" }, name.to_string())
            }),
        ]
    }
}

/// Returns the place of a refiner or rival among all of them, or after them.
fn place(refiner: &str) -> usize {
    let names = || RefinerConfig::NAMES.iter().chain(Rival::NAMES);
    names().position(|known| *known == refiner).unwrap_or(names().count())
}

/// Returns the shape of a refiner, one in all charts.
fn shape(refiner: &str) -> Shape {
    Shape::nth(place(refiner))
}
