//! Error targets on small furnished scenes that no constant was chosen by: nine kinds of furniture, six arrangements of
//! each, under lamps of six kinds.
//!
//! [`run`] renders each by error target, and holds the true error against the target and against what the frame expected.

use std::f64::consts::TAU;
use std::path::Path;

use anyhow::{Context as _, Result};
use glam::Vec3;
use halflight_core::scene::Scene;
use halflight_cpu::config::{PipelineConfig, RefinerConfig};
use halflight_cpu::prepared::PreparedScene;
use halflight_cpu::refine::LatticeConfig;
use halflight_metrics::{Image, nmse2, tone_map, write_file, write_png};
use halflight_scene::SceneError;

use crate::reference::{ReferenceConfig, receivers, reference};
use crate::results::{Provenance, Table};
use crate::run::Progress;

/// Error target, NMSE₂.
const DEFAULT_TARGET: f32 = 1e-4;

/// Name of the experiment.
pub const NAME: &str = "furnished";

/// Title of the experiment.
pub const TITLE: &str = "Error targets on small furnished scenes that no constant was chosen by";

/// Kinds of furniture, as the generator `furnished` knows them.
const KINDS: [&str; 9] =
    ["objects", "table", "bookcase", "chairs", "stairs", "plants", "corner", "wires", "conference"];

/// Arrangements of each kind.
const SEEDS: u32 = 6;

/// Lamp: a corner, two edges and the radiance.
struct Lamp([f64; 3], [f64; 3], [f64; 3], f64);

/// Lamps: a panel in the ceiling, a large one, a strip, a desk lamp, a window and a softbox.
const LAMPS: [Lamp; 6] = [
    Lamp([-0.3, 2.65, -0.3], [0.6, 0.0, 0.0], [0.0, 0.0, 0.6], 20.0),
    Lamp([-1.0, 2.6, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0], 3.0),
    Lamp([-1.1, 2.5, -0.6], [2.1, 0.0, 1.2], [-0.08, 0.0, 0.14], 30.0),
    Lamp([0.55, 1.35, 0.35], [0.12, 0.0, 0.0], [0.0, 0.0, 0.12], 60.0),
    Lamp([-2.9, 0.8, -0.75], [0.0, 1.2, 0.0], [0.0, 0.0, 1.5], 8.0),
    Lamp([1.1, 2.0, 1.9], [0.55, 0.0, -0.55], [0.35, -0.5, 0.35], 12.0),
];

/// Scene of the set, or another.
#[derive(Clone, Debug)]
pub struct Case {
    /// Kind and number; a bundled name or a path for other scenes.
    pub name: String,
    /// Text of the scene file; `None` for other scenes.
    pub text: Option<String>,
}

impl Case {
    fn load(&self) -> Result<Scene, SceneError> {
        let loaded = match &self.text {
            Some(text) => halflight_scene::parse(text, &self.name, Path::new(""))?,
            None => halflight_scene::resolve(&self.name)?,
        };
        Ok(loaded.scene)
    }
}

/// Returns all scenes.
pub fn cases() -> Vec<Case> {
    let numbers = (0..KINDS.len() as u32).flat_map(|kind| (1..=SEEDS).map(move |seed| (kind, seed)));
    numbers.map(|(kind, seed)| case(kind, seed)).collect()
}

fn case(kind: u32, seed: u32) -> Case {
    let number = kind * SEEDS + seed - 1;
    let lamp = (seed - 1 + kind) % 6;
    // The corner's own wall stands before the window, and the rail of the stairs goes through the desk lamp.
    let lamp = if matches!((KINDS[kind as usize], lamp), ("corner", 4) | ("stairs", 3)) { 0 } else { lamp };
    let Lamp(corner, u, v, radiance) = LAMPS[lamp as usize];
    // Round the middle by the golden ratio, so that no two are seen from the same side.
    let share = |step: f64| (f64::from(number) * step).fract();
    let angle = 0.8 * TAU * (share(0.618_034) - 0.5) * 0.5;
    let (away, high) = (2.0 + 1.0 * share(0.754_878), 0.9 + 1.3 * share(0.569_840));
    // From outside, its walls hide everything.
    let angle = if KINDS[kind as usize] == "corner" { angle.abs() } else { angle };
    let (x, z) = (away * angle.sin(), away * angle.cos());
    let (aim, fov) = (0.35 + 0.4 * share(0.324_718), 35.0 + 20.0 * share(0.882_646));
    let kind = KINDS[kind as usize];
    // A window needs no wall on its own side, and nothing may stand behind the softbox.
    let walls = [4, 0, 1, 4, 1, 0][((number + seed) % 6) as usize];
    let text = format!(
        "[camera]\neye = [{x:.4}, {high:.4}, {z:.4}]\ntarget = [0, {aim:.4}, 0]\nfov_y_deg = {fov:.3}\n\n[[light]]\ncorner = {corner:?}\n\
         edge_u = {u:?}\nedge_v = {v:?}\nradiance = [{radiance}, {radiance}, {radiance}]\n\n[[mesh]]\ngenerator = \"furnished\"\n\
         kind = \"{kind}\"\nseed = {seed}\nwalls = {walls}\n"
    );
    Case { name: format!("{kind}-{seed}"), text: Some(text) }
}

/// Scenes, sizes and samples of a run.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Scenes.
    pub cases: Vec<Case>,
    /// Sizes of the images.
    pub sizes: Vec<[u32; 2]>,
    /// Error target, NMSE₂.
    pub target: f32,
    /// Light samples of the references.
    pub samples: u32,
}

impl Plan {
    /// Returns the whole set, or every third scene small where `quick`; `scenes` instead where any are named.
    pub fn new(scenes: &[String], size: Option<[u32; 2]>, quick: bool) -> Self {
        let step = if quick { 3 } else { 1 };
        let named = scenes.iter().map(|name| Case { name: name.clone(), text: None });
        let sizes = if quick { vec![[320, 240]] } else { vec![[320, 240], [640, 480]] };
        Self {
            cases: if scenes.is_empty() {
                cases().into_iter().step_by(step).collect()
            } else {
                named.collect()
            },
            sizes: size.map_or(sizes, |size| vec![size]),
            target: DEFAULT_TARGET,
            samples: if quick { 1024 } else { 4096 },
        }
    }

    /// Returns the number of images.
    pub fn rows(&self) -> usize {
        self.cases.len() * self.sizes.len()
    }
}

/// Measurements of one image.
#[derive(Clone, Debug)]
pub struct Row {
    /// Name of the scene.
    pub scene: String,
    /// Triangles of the scene.
    pub triangles: usize,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Error target, NMSE₂.
    pub target: f32,
    /// True NMSE₂ against the reference.
    pub nmse2: f64,
    /// NMSE₂ that the frame expected.
    pub expected: f64,
    /// NMSE₂ that is left in the reference itself.
    pub noise: f64,
    /// Number of fragments.
    pub fragments: u64,
    /// Number of shadow rays.
    pub rays: u64,
}

impl Row {
    /// Returns whether the error is at most twice the target.
    pub fn holds(&self) -> bool {
        self.nmse2 <= 2.0 * f64::from(self.target)
    }

    /// Returns whether the expected error is within a factor of 2 of the true one.
    pub fn is_expected(&self) -> bool {
        (0.5..=2.0).contains(&(self.expected / self.nmse2))
    }
}

/// Renders everything; references are kept in `cache`, scene files and worse pictures than asked for in `out`.
///
/// # Errors
/// A scene cannot be rendered, or a file not be written.
pub fn run(plan: &Plan, cache: &Path, out: &Path, progress: &Progress) -> Result<Vec<Row>> {
    fs_err::create_dir_all(cache)?;
    fs_err::create_dir_all(out)?;
    let mut rows = Vec::with_capacity(plan.rows());
    for case in &plan.cases {
        let scene = case.load()?;
        if let Some(text) = &case.text {
            write_file(&out.join(format!("{}.toml", case.name)), text.as_bytes())?;
        }
        let scene = PreparedScene::new(scene).with_context(|| format!("scene {}", case.name))?;
        for &[width, height] in &plan.sizes {
            progress.now(format!("{} {width}x{height}", case.name));
            let config =
                ReferenceConfig { width, height, samples: plan.samples, ..ReferenceConfig::default() };
            let truth = reference(&scene, &config, Some(cache), &mut |_, _| {})?;
            let refiner = LatticeConfig { target: plan.target, ..LatticeConfig::default() };
            let config = PipelineConfig {
                width,
                height,
                refiner: RefinerConfig::Lattice(refiner),
                ..PipelineConfig::default()
            };
            let named = || format!("row {}", case.name);
            let mut pipeline = config.builder(&scene).build().with_context(named)?;
            let frame = pipeline.render().with_context(named)?.clone();
            let mask = receivers(pipeline.gbuffer());
            let view = |pixels| Image::new(width, height, pixels)?.with_mask(&mask);
            let (image, right) = (view(&frame.irradiance)?, view(&truth.irradiance)?);
            let row = Row {
                scene: case.name.clone(),
                triangles: scene.bvh().triangle_count(),
                size: [width, height],
                target: plan.target,
                nmse2: nmse2(image, right).with_context(named)?,
                expected: frame.stats.expected_nmse2.unwrap_or(f64::NAN),
                noise: truth.noise_nmse2,
                fragments: frame.stats.fragments.total,
                rays: frame.stats.rays.total,
            };
            if !row.holds() {
                show(&row, &frame.irradiance, &truth.irradiance, out)?;
            }
            rows.push(row);
            progress.advance(1);
        }
    }
    Ok(rows)
}

/// Writes a picture of an image beside its reference and where they differ.
fn show(row: &Row, image: &[Vec3], truth: &[Vec3], out: &Path) -> Result<()> {
    let [width, height] = row.size.map(|side| side as usize);
    let brightest = truth.iter().fold(0.0f32, |most, rgb| most.max(rgb.max_element()));
    let mean = truth.iter().map(|rgb| rgb.element_sum() / 3.0).sum::<f32>() / truth.len() as f32;
    let exposure = 0.5 / mean.max(brightest * 1e-3).max(f32::MIN_POSITIVE);
    let [left, right] = [image, truth].map(|linear| tone_map(linear, exposure));
    // Differences of half the mean and more are white.
    let off: Vec<Vec3> = image.iter().zip(truth).map(|(a, b)| (*a - *b).abs() / (0.5 * mean)).collect();
    let off: Vec<[u8; 3]> = off
        .iter()
        .map(|rgb| (rgb.clamp(Vec3::ZERO, Vec3::ONE) * 255.0).to_array().map(|one| one as u8))
        .collect();
    let mut rgb = Vec::with_capacity(3 * width * height);
    for y in 0..height {
        for part in [&left, &right, &off] {
            rgb.extend_from_slice(&part[y * width..(y + 1) * width]);
        }
    }
    let name = Path::new(&row.scene).file_stem().map_or_else(String::new, |n| n.to_string_lossy().into());
    let file = out.join(format!("{name}-{width}x{height}.png"));
    write_png(&file, 3 * width as u32, height as u32, &rgb)?;
    Ok(())
}

/// Returns rows as a table.
pub fn table(rows: &[Row], provenance: &Provenance) -> Table {
    let columns = [
        "scene",
        "triangles",
        "width",
        "height",
        "target",
        "nmse2",
        "expected_nmse2",
        "reference_nmse2",
        "fragments",
        "rays",
        "commit",
        "machine",
    ];
    let line = |row: &Row| {
        [
            row.scene.clone(),
            row.triangles.to_string(),
            row.size[0].to_string(),
            row.size[1].to_string(),
            format!("{:e}", row.target),
            format!("{:.3e}", row.nmse2),
            format!("{:.3e}", row.expected),
            format!("{:.1e}", row.noise),
            row.fragments.to_string(),
            row.rays.to_string(),
            provenance.commit.clone(),
            provenance.machine.clone(),
        ]
    };
    Table::new(columns, rows.iter().map(line))
}

/// Returns a summary of rows in words: how many hold, how well errors were expected, and the worst of each.
pub fn summary(rows: &[Row]) -> String {
    let over = |row: &Row| row.nmse2 / f64::from(row.target);
    let off = |row: &Row| (row.expected / row.nmse2).max(row.nmse2 / row.expected);
    let count = |holds: fn(&Row) -> bool| rows.iter().filter(|&row| holds(row)).count();
    let worst = |measure: &dyn Fn(&Row) -> f64| {
        let row = rows.iter().max_by(|a, b| measure(a).total_cmp(&measure(b)));
        row.map_or_else(String::new, |row| {
            let [width, height] = row.size;
            format!("{:.2} times at worst ({} {width}x{height})", measure(row), row.scene)
        })
    };
    format!(
        "{} of {} errors are at most twice their target, {}; {} are within a factor of 2 of what was expected, {}",
        count(Row::holds),
        rows.len(),
        worst(&over),
        count(Row::is_expected),
        worst(&off)
    )
}
