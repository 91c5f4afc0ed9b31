//! Indirect light in awkward cases: thin walls, boxes in boxes, lights that leave, rooms without light.

use std::fmt;

use anyhow::{Context as _, Result, bail};
use glam::Vec3;
use halflight_core::scene::Scene;
use halflight_cpu::config::{IndirectConfig, Named as _, PipelineConfig, RefinerConfig};
use halflight_cpu::prepared::PreparedScene;
use halflight_metrics::{Image, nmse2};

use super::judge::sound;
use super::scenes::{Set, square_light};
use crate::reference::bounce::{luminances, one_bounce};
use crate::reference::{ReferenceConfig, receivers, seen};
use crate::results::{Provenance, Table};
use crate::run::Progress;

/// Start of the names of these cases.
pub const PREFIX: &str = "bounce-";

/// Width and height, pixels.
const SIZE: [u32; 2] = [96, 72];

/// Rays of each pixel of the references.
const RAYS: u32 = 512;

/// Relative error up to which a picture passes, of indirect light and of glossy surfaces.
const PASSES: f64 = 0.1;

/// Relative error above which a picture fails: half of the light is missing or misplaced.
const FAILS: f64 = 0.5;

/// Mean irradiance of a dark picture that counts as none, W/m²: a ten-thousandth of that of the lit room. Where surfaces meet, single rays in millions pass
/// between them within rounding.
const NONE: f64 = 1e-5;

/// Case: a room of 6 × 6 × 2 m, or what is said.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name in tables.
    pub name: &'static str,
    /// Difficulty, in a few words.
    pub title: &'static str,
    /// True if no indirect light arrives.
    pub dark: bool,
    scene: Scene,
}

/// Verdict on a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// No light where there is none, and a relative error of at most 10 % elsewhere.
    Pass,
    /// Light where there is none, or a relative error of at most 50 %.
    Degraded,
    /// A relative error above that.
    Fails,
}

impl Verdict {
    /// Returns the verdict on a relative error.
    pub(super) fn of_error(error: f64) -> Self {
        match error {
            error if error > FAILS => Self::Fails,
            error if error > PASSES => Self::Degraded,
            _ => Self::Pass,
        }
    }
}

/// Returns all cases, or the one of a name.
pub(super) fn chosen<T>(
    mut cases: Vec<T>,
    name: Option<&str>,
    name_of: impl Fn(&T) -> &'static str,
) -> Result<Vec<T>> {
    cases.retain(|case| name.is_none_or(|name| name_of(case) == name));
    match (name, cases.is_empty()) {
        (Some(name), true) => bail!("there is no case `{name}`"),
        _ => Ok(cases),
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Pass => "pass",
            Self::Degraded => "degraded",
            Self::Fails => "fails",
        })
    }
}

/// Method in a case.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Name of the case.
    pub case: &'static str,
    /// Difficulty of the case.
    pub title: &'static str,
    /// Name of the method.
    pub method: &'static str,
    /// Verdict.
    pub verdict: Verdict,
    /// Relative error of the luminance, less the reference's noise; `None` in dark cases.
    pub error: Option<f64>,
    /// Mean luminance of the picture and of the reference, W/m².
    pub means: [f64; 2],
}

/// Returns all cases.
pub fn cases() -> Vec<Case> {
    let case = |name, title, set: Set| Case { name, title, dark: false, scene: set.0 };
    let dark = |name, title, set: Set| Case { dark: true, ..case(name, title, set) };
    let lamp = |x: f32, y: f32| square_light(Vec3::new(x, y, 0.0), 1.0);
    let inner = room().block(Vec3::new(-1.0, 0.3, -1.5), Vec3::new(1.0, 1.3, 0.0)).light(lamp(0.0, 1.9));
    let inside = inner.clone().seen(Vec3::new(0.0, 0.8, -0.2), Vec3::new(0.0, 0.6, -1.5));
    let wall = Set::floor()
        .quad(Vec3::new(0.0, 0.0, -5.0), Vec3::Y * 3.0, Vec3::Z * 10.0)
        .light(square_light(Vec3::new(0.6, 2.5, 0.0), 1.0))
        .seen(Vec3::new(-1.5, 4.5, 5.0), Vec3::new(-0.5, 0.0, 0.0));
    let parted = room().quad(Vec3::new(0.0, 0.0, -3.0), Vec3::Y * 2.0, Vec3::Z * 6.0).light(lamp(1.5, 1.9));
    let up = square_light(Vec3::new(0.0, 1.0, 0.0), 1.0).reversed();
    vec![
        case("bounce-thin-wall", "a wall without thickness close to the light, open around it", wall),
        case("bounce-box-in-box", "a closed box in a lit room, from outside", inner),
        dark("bounce-in-the-box", "the same from inside the box: no light at all", inside),
        dark(
            "bounce-dark-room",
            "half a closed room, the light in the other half: no light at all",
            parted.seen(Vec3::new(-0.5, 1.2, 2.5), Vec3::new(-2.0, 0.4, -1.0)),
        ),
        case(
            "bounce-light-at-the-ceiling",
            "a light of the room in the plane of its ceiling",
            room().light(lamp(0.0, 2.0)),
        ),
        dark(
            "bounce-light-left",
            "the light has left the closed room: no light at all",
            room().light(lamp(0.0, 2.5)),
        ),
        dark(
            "bounce-light-at-nothing",
            "a light over an open floor that shines up: no light at all",
            Set::floor().light(up),
        ),
    ]
}

/// Returns the closed room, seen from a wall.
fn room() -> Set {
    Set::bare()
        .block(Vec3::new(-3.0, 0.0, -3.0), Vec3::new(3.0, 2.0, 3.0))
        .seen(Vec3::new(0.0, 1.2, 2.5), Vec3::new(0.0, 0.6, -1.0))
}

/// Renders and judges all cases, or the one of a name.
///
/// # Errors
/// No case has the name, a reference cannot be rendered, or a picture is not finite or negative.
pub fn run(name: Option<&str>, progress: &Progress) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for case in &chosen(cases(), name, |case| case.name)? {
        progress.now(case.name);
        rows.extend(judged(case, SIZE, RAYS)?);
    }
    Ok(rows)
}

/// Renders and judges all methods in a case.
fn judged(case: &Case, [width, height]: [u32; 2], rays: u32) -> Result<Vec<Row>> {
    let scene = PreparedScene::new(case.scene.clone()).with_context(|| format!("scene {}", case.name))?;
    let config = ReferenceConfig { width, height, samples: rays, ..ReferenceConfig::default() };
    let truth = one_bounce(&scene, &config, None, &mut |_, _| {})?;
    let mask = receivers(&seen(&scene, [width, height]));
    let seen = mask.iter().filter(|taken| **taken).count().max(1) as f64;
    let mean = |grey: &[Vec3]| grey.iter().map(|pixel| f64::from(pixel.x)).sum::<f64>() / seen;
    let expected = luminances(&truth.irradiance);
    let methods = IndirectConfig::all().into_iter().filter(|method| *method != IndirectConfig::None);
    methods
        .map(|indirect| {
            let named = || format!("{}, {}", case.name, indirect.name());
            let refiner = RefinerConfig::PerPixel;
            let config = PipelineConfig { width, height, refiner, indirect, ..PipelineConfig::default() };
            let mut pipeline = config.builder(&scene).build().with_context(named)?;
            let image = pipeline.render().with_context(named)?;
            if let Err(fault) = sound(&image.indirect, width) {
                bail!("{}: {fault}", named());
            }
            let found = luminances(&image.indirect);
            let means = [mean(&found), mean(&expected)];
            let error = if case.dark {
                None
            } else {
                let view = |pixels| -> Result<Image<'_>> {
                    Ok(Image::new(width, height, pixels)?.with_mask(&mask)?)
                };
                let nmse2 = nmse2(view(&found)?, view(&expected)?).with_context(named)?;
                Some((nmse2 - truth.noise_luminance).max(0.0).sqrt())
            };
            let verdict = match error {
                None if means[0] > NONE => Verdict::Degraded,
                None => Verdict::Pass,
                Some(error) => Verdict::of_error(error),
            };
            let &Case { name, title, .. } = case;
            Ok(Row { case: name, title, method: indirect.name(), verdict, error, means })
        })
        .collect()
}

/// Returns a table with a line for each row.
pub fn table(rows: &[Row], provenance: &Provenance) -> Table {
    let line = |row: &Row| {
        [
            row.case.to_string(),
            row.title.to_string(),
            row.method.to_string(),
            row.verdict.to_string(),
            row.error.map_or(String::new(), |error| format!("{error:.4}")),
            format!("{:.4e}", row.means[0]),
            format!("{:.4e}", row.means[1]),
            provenance.commit.clone(),
            provenance.machine.clone(),
        ]
    };
    let columns = [
        "case",
        "difficulty",
        "method",
        "verdict",
        "relative_error",
        "mean",
        "reference_mean",
        "commit",
        "machine",
    ];
    Table::new(columns, rows.iter().map(line))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(name: &str) -> Vec<Row> {
        let case = cases().into_iter().find(|case| case.name == name).unwrap();
        judged(&case, [32, 24], 32).unwrap()
    }

    #[test]
    fn gathered_light_is_nowhere_where_there_is_none() {
        for name in ["bounce-in-the-box", "bounce-dark-room", "bounce-light-left", "bounce-light-at-nothing"]
        {
            let rows = rows(name);
            let gather = rows.iter().find(|row| row.method == "gather").unwrap();
            assert_eq!(
                (gather.verdict, gather.means, gather.error),
                (Verdict::Pass, [0.0; 2], None),
                "{name}"
            );
            // The volume may leak, but not where no surface is lit at all.
            let lpv = rows.iter().find(|row| row.method == "lpv").unwrap();
            assert_ne!(lpv.verdict, Verdict::Fails, "{name}");
            assert!(name != "bounce-light-at-nothing" || lpv.means[0] == 0.0);
        }
    }

    #[test]
    fn lit_rooms_have_an_error_and_names_are_their_own() {
        let rows = rows("bounce-box-in-box");
        assert!(rows.iter().all(|row| row.error.is_some() && row.means[1] > 0.0), "{rows:?}");
        let table = table(&rows, &Provenance::default());
        assert_eq!((table.lines.len(), table.lines[0].cells.len()), (2, table.columns.len()));
        assert!(cases().iter().all(|case| case.name.starts_with(PREFIX)));
        let fault = run(Some("bounce-nowhere"), &Progress::hidden()).unwrap_err().to_string();
        assert!(fault.contains("`bounce-nowhere`"), "{fault}");
    }
}
