//! Charts, and those of finished rows: error against time, rays or the size of the light.

use halflight_cpu::config::{Named, RefinerConfig, UpsamplerConfig};
use plotters::prelude::DrawingBackend;

use super::draw::{Canvas, Drawn, draw};
use super::drawing::Drawing;
use super::pareto;
use super::record::Finished;

/// A chart; y has a logarithmic scale.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Title.
    pub title: String,
    /// Quantity and unit on x.
    pub x_label: String,
    /// Quantity on y.
    pub y_label: String,
    /// Scale of x.
    pub x_scale: Scale,
    /// What is shown.
    pub series: Vec<Series>,
    /// What the marks mean.
    pub key: Vec<KeyGroup>,
    /// The reference's own error, drawn as a line.
    pub noise: Option<f64>,
    /// Whether to draw the Pareto front.
    pub pareto: bool,
}

/// How an axis spreads its quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// By powers of ten.
    Log,
}

/// Points with one mark.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// How they are marked.
    pub mark: Mark,
    /// The points.
    pub points: Vec<Point>,
    /// Whether a line joins them.
    pub connected: bool,
}

/// A row in a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Such as time, rays or size.
    pub x: f64,
    /// Such as an error.
    pub y: f64,
    /// The row.
    pub name: String,
    /// A word beside it.
    pub note: Option<String>,
}

/// A mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Mark {
    /// Outline.
    pub shape: Shape,
    /// Colour, sRGB.
    pub rgb: [u8; 3],
    /// Filled or hollow.
    pub filled: bool,
}

/// The outline of a mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shape {
    /// A circle.
    Circle,
    /// A triangle on its base.
    Triangle,
    /// A square.
    Square,
    /// A square on its corner.
    Diamond,
}

/// Part of a key.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyGroup {
    /// What varies.
    pub title: String,
    /// Marks and meanings.
    pub entries: Vec<(Mark, String)>,
}

impl Shape {
    /// All shapes.
    pub const ALL: [Self; 4] = [Self::Circle, Self::Triangle, Self::Square, Self::Diamond];
}

impl Scale {
    pub(crate) fn apply(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Log => value.log10(),
        }
    }
}

/// Okabe and Ito's colours, told apart by the colour-blind as well.
pub(crate) const COLORS: [[u8; 3]; 7] = [
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

    fn key(&self) -> Vec<KeyGroup> {
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
fn distinct<'a>(
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

/// What a chart sets the error against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Against {
    /// Time of a frame.
    Time,
    /// Shadow rays of a frame.
    Rays,
    /// Size of the light; rows that differ in nothing else are joined.
    Light,
}

/// NMSE₂ (NMSE against the light's size, as in Koa17 Fig. 17) of these rows.
pub fn errors(title: String, rows: &[&Finished], against: Against) -> Chart {
    let marks = Marks::of(rows);
    let light = against == Against::Light;
    let x = |row: &Finished| match against {
        Against::Time => row.record.total_ms,
        Against::Rays => row.record.rays as f64,
        Against::Light => f64::from(row.record.light_scale),
    };
    let counts = distinct(rows.iter().copied().filter(|row| row.record.refiner == "full"), |row| {
        row.record.samples.to_string()
    });
    let mut series: Vec<(String, Series)> = Vec::new();
    for row in rows {
        let note =
            (row.record.refiner == "full" && counts.len() > 1).then(|| format!("{} spp", row.record.samples));
        let y = if light { row.record.nmse } else { row.record.nmse2 };
        let point = Point { x: x(row), y, name: row.label.clone(), note };
        match series.iter_mut().find(|(name, _)| *name == row.row) {
            Some((_, series)) if light => series.points.push(point),
            _ => {
                let one = Series { mark: marks.mark(row), points: vec![point], connected: light };
                series.push((row.row.clone(), one));
            }
        }
    }
    let (x_label, x_scale) = match against {
        Against::Time => ("time of a frame, ms", Scale::Log),
        Against::Rays => ("shadow rays of a frame", Scale::Log),
        Against::Light => ("light's edge, in parts of the scene file's", Scale::Linear),
    };
    let noise = rows.iter().map(|row| row.record.reference_noise).fold(0.0, f64::max);
    Chart {
        title,
        x_label: x_label.to_string(),
        y_label: if light { "NMSE (Koa17)" } else { "NMSE₂ = SSE / Σ reference²" }.to_string(),
        x_scale,
        series: series.into_iter().map(|(_, series)| series).collect(),
        key: marks.key(),
        noise: (!light && noise > 0.0).then_some(noise),
        pareto: !light,
    }
}

impl Chart {
    /// The points that no other beats, by ascending x; none where no front is drawn.
    pub fn front(&self) -> Vec<&Point> {
        if !self.pareto {
            return Vec::new();
        }
        let points: Vec<&Point> = self.series.iter().flat_map(|series| &series.points).collect();
        let places: Vec<(f64, f64)> = points.iter().map(|point| (point.x, point.y)).collect();
        pareto::front(&places).into_iter().map(|index| points[index]).collect()
    }
}

impl Drawing for Chart {
    fn title(&self) -> &str {
        &self.title
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn<DB> {
        draw(canvas, self)
    }
}

#[cfg(test)]
mod tests {
    use super::super::record::tests::finished;
    use super::*;

    fn rows() -> Vec<Finished> {
        vec![
            finished("nichols", "bilinear", 10.0, 1e-2),
            finished("nichols", "delaunay", 12.0, 1e-3),
            finished("sfvt-gass", "delaunay", 20.0, 2e-3),
            finished("full", "bilinear", 100.0, 1e-5),
        ]
    }

    fn chart(against: Against) -> Chart {
        let rows = rows();
        errors("A hall".to_string(), &rows.iter().collect::<Vec<_>>(), against)
    }

    #[test]
    fn the_front_leaves_out_what_is_beaten() {
        let chart = chart(Against::Time);
        let names: Vec<&str> = chart.front().iter().map(|point| point.name.as_str()).collect();
        assert_eq!(
            names,
            ["nichols · bilinear · ratio", "nichols · delaunay · ratio", "full · bilinear · ratio"]
        );
    }

    #[test]
    fn the_svg_names_everything() {
        for against in [Against::Time, Against::Rays] {
            let svg = chart(against).svg().unwrap();
            for words in [
                "A hall",
                "nichols",
                "sfvt-gass",
                "full (Monte Carlo)",
                "bilinear",
                "delaunay",
                "ratio",
                "noise of",
            ] {
                assert!(svg.contains(words), "{words} is missing");
            }
            // Four rows and nine entries of the key, each a filled polygon.
            assert!(svg.matches("<polygon").count() >= 10);
        }
    }

    #[test]
    fn the_bitmap_shows_text_and_marks() {
        let (width, height, pixels) = chart(Against::Time).pixels().unwrap();
        assert_eq!(pixels.len(), (width * height) as usize);
        let blue = |p: &&[u8; 3]| **p == COLORS[0];
        assert!(pixels.iter().filter(blue).count() > 50);
        // The title's row band holds ink.
        let title = &pixels[28 * width as usize..72 * width as usize];
        assert!(title.iter().filter(|p| p[0] < 128).count() > 50);
    }

    #[test]
    fn names_with_dots_stay_whole() {
        let folder = std::env::temp_dir().join(format!("halflight-chart-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        chart(Against::Rays).write(&folder.join("hall-x0.5-rays")).unwrap();
        for name in ["hall-x0.5-rays.svg", "hall-x0.5-rays.png"] {
            assert!(folder.join(name).is_file(), "{name} is missing");
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn colours_tell_backends_apart_where_these_vary_most() {
        let mut rows = rows();
        for (row, name) in rows.iter_mut().zip(["bvh", "beam", "raster4d", "voxel"]) {
            row.record.visibility = name.to_string();
        }
        let chart = errors("Backends".to_string(), &rows.iter().collect::<Vec<_>>(), Against::Time);
        assert_eq!(chart.key[1].title, "Colour: backend");
        let colors: std::collections::BTreeSet<[u8; 3]> =
            chart.series.iter().map(|series| series.mark.rgb).collect();
        assert_eq!(colors.len(), 4);
    }

    #[test]
    fn sizes_of_light_are_joined() {
        let mut rows = rows();
        let mut larger = rows.clone();
        larger.iter_mut().for_each(|row| row.record.light_scale = 2.0);
        rows.append(&mut larger);
        let chart = errors("Sizes".to_string(), &rows.iter().collect::<Vec<_>>(), Against::Light);
        assert_eq!(chart.series.len(), 4);
        assert!(chart.series.iter().all(|series| series.connected && series.points.len() == 2));
        assert!(chart.front().is_empty() && chart.svg().unwrap().contains("<polyline"));
    }
}
