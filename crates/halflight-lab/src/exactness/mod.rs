//! Exactness suite: masks of all exact backends are compared with each other and with brute force bit for bit.
//!
//! [`check`] compares masks of the receivers of images of a scene; [`primary`] compares primary hits with brute force;
//! [`certificates`] attacks the certificates of beams.

pub mod certificates;
pub mod primary;
mod truth;

use std::path::Path;
use std::sync::Arc;

use anyhow::{Result, bail};
use halflight_core::frame::{Frame, Sharing};
use halflight_core::gbuffer::GBuffer;
use halflight_core::mask::{MaskBatch, Purpose};
use halflight_core::pattern::{Pattern, PatternKind};
use halflight_core::pyramid::Pyramid;
use halflight_core::scene::Scene;
use halflight_core::stages::Visibility;
use halflight_cpu::bvh::Bvh;
use halflight_cpu::config::{Named, VisibilityConfig};
use halflight_cpu::gbuffer;
use halflight_cpu::horizon;
use halflight_cpu::pipeline::PipelineError;
use halflight_cpu::requests::Requests;
use halflight_metrics::WriteError;
use serde::Serialize;

use crate::results::{self, Provenance};

/// Scenes that are compared where none is named.
pub const SCENES: [&str; 5] = ["atrium", "nave", "hairball", "tree", "soup"];

/// Patterns of all comparisons; 4D rasterization cannot answer the last.
const PATTERNS: [Pattern; 3] = [
    Pattern { kind: PatternKind::Grid, columns: 8, rows: 8 },
    Pattern { kind: PatternKind::ShiftedRows, columns: 16, rows: 16 },
    Pattern { kind: PatternKind::Jittered, columns: 8, rows: 8 },
];

/// Number of pairs that are compared, and their seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Least number of pairs of a receiver and a light sample that every backend is asked for.
    pub pairs: u64,
    /// Least number of these pairs that brute force is asked for.
    pub brute_force: u64,
    /// Seed of the light samples and of the choice of receivers for brute force.
    pub seed: u32,
}

/// Backend and its name.
pub struct Backend {
    /// Name in tables.
    pub name: &'static str,
    /// Backend under this name.
    pub visibility: Box<dyn Visibility>,
}

/// Returns the exact backends: `bvh`, which the others are compared with, `raster4d`, `beam` and `auto`.
///
/// # Errors
/// A backend cannot be set up.
pub fn backends(bvh: &Arc<Bvh>) -> Result<Vec<Backend>, PipelineError> {
    let exact = VisibilityConfig::NAMES.iter().filter(|&&name| name != "voxel");
    exact
        .filter_map(|&name| VisibilityConfig::named(name).map(|config| (name, config)))
        .map(|(name, config)| Ok(Backend { name, visibility: config.stage(bvh)? }))
        .collect()
}

/// Comparison of a backend, or brute force, with the first backend in a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Agreement {
    /// Name of the backend.
    pub name: &'static str,
    /// Number of pairs that were compared.
    pub pairs: u64,
    /// Number of pairs in which the two differ.
    pub different: u64,
}

impl Agreement {
    fn new(name: &'static str) -> Self {
        Self { name, pairs: 0, different: 0 }
    }

    /// Adds a word of two masks.
    fn add(&mut self, wanted: u64, a: u64, b: u64) {
        self.pairs += u64::from(wanted.count_ones());
        self.different += u64::from(((a ^ b) & wanted).count_ones());
    }
}

/// Compares the other backends with the first on every receiver of images of the scene, of growing size until the pairs
/// are enough, and the first with brute force on receivers spread over the first image. `progress` is told how many pairs
/// have been compared.
///
/// # Errors
/// An image has nothing to ask about.
pub fn check(
    scene: &Scene,
    bvh: &Bvh,
    backends: &mut [Backend],
    settings: &Settings,
    mut progress: impl FnMut(u64),
) -> Result<Vec<Agreement>> {
    let mut brute_force = Agreement::new("brute force");
    let mut agreements: Vec<_> =
        backends.iter().skip(1).map(|backend| Agreement::new(backend.name)).collect();
    // Half of the samples are below a horizon, say; 4D rasterization answers for two of the patterns.
    let pixels = settings.pairs / 160 + 256;
    let mut height = (pixels as f64 * 0.75).sqrt().ceil() as u32;
    let (mut seen, pyramid) = (GBuffer::default(), Pyramid::default());
    for index in 0.. {
        gbuffer::trace(bvh, scene, height * 4 / 3, height, &mut seen);
        let frame = Frame {
            scene,
            gbuffer: &seen,
            pyramid: &pyramid,
            pattern: PATTERNS[0],
            sharing: Sharing::Receiver,
            index,
            seed: settings.seed,
        };
        backends.iter_mut().for_each(|backend| backend.visibility.prepare(&frame));
        let mut asked = 0;
        for (light, pattern) in (0..scene.lights.len() as u32).flat_map(|l| PATTERNS.map(|p| (l, p))) {
            let mut batch = questions(&Frame { pattern, ..frame }, light);
            let Some((first, others)) = backends.split_first_mut() else { return Ok(agreements) };
            Requests::new(first.visibility.as_mut(), bvh).masks(&frame, &mut batch);
            let expected = batch.parts().visible.to_vec();
            for (backend, agreement) in others.iter_mut().zip(&mut agreements) {
                if backend.visibility.supports(pattern).is_ok() {
                    Requests::new(backend.visibility.as_mut(), bvh).masks(&frame, &mut batch);
                    let parts = batch.parts();
                    let before = agreement.pairs;
                    for ((&wanted, &a), &b) in parts.wanted.iter().zip(&expected).zip(&*parts.visible) {
                        agreement.add(wanted, a, b);
                    }
                    asked += agreement.pairs - before;
                    progress(agreement.pairs - before);
                }
            }
            if index == 0 {
                let share = settings.brute_force.div_ceil(3 * scene.lights.len() as u64);
                let before = brute_force.pairs;
                truth::compare(&frame, &batch, &expected, share, &mut brute_force);
                progress(brute_force.pairs - before);
            }
        }
        if asked == 0 {
            bail!("nothing in view faces the light, so that there is nothing to compare");
        }
        if agreements.iter().all(|agreement| agreement.pairs >= settings.pairs) {
            break;
        }
        height += height / 4 + 1;
    }
    agreements.push(brute_force);
    Ok(agreements)
}

/// Returns a query for every receiver in view, without samples below a horizon.
fn questions(frame: &Frame, light: u32) -> MaskBatch {
    let mut batch = MaskBatch::default();
    batch.reset(light, frame.pattern, Purpose::Final);
    for pixel in 0..frame.gbuffer.pixels() {
        if let Some(receiver) = frame.gbuffer.receiver(pixel) {
            let pixel = pixel as u32;
            let key = frame.key(light, pixel, pixel);
            batch.push(receiver.origin, receiver.normal, pixel, key, None);
        }
    }
    horizon::cull(frame.light(light), &mut batch);
    batch
}

/// Row of the table: a backend in a scene.
#[derive(Clone, Debug, Serialize)]
pub struct Record {
    /// Name of the scene.
    pub scene: String,
    /// Triangles of the scene.
    pub triangles: usize,
    /// Backend that was compared with `bvh`.
    pub backend: &'static str,
    /// Number of pairs of a receiver and a light sample.
    pub pairs: u64,
    /// Number of pairs in which they differ.
    pub different: u64,
}

/// Returns the rows as a table for people.
pub fn table(records: &[Record]) -> String {
    let mut text = format!(
        "{:<14} {:>10}  {:<12} {:>12} {:>10}\n",
        "scene", "triangles", "bvh against", "pairs", "different"
    );
    for Record { scene, triangles, backend, pairs, different } in records {
        text += &format!("{scene:<14} {triangles:>10}  {backend:<12} {pairs:>12} {different:>10}\n");
    }
    text
}

/// Writes rows to the CSV file `name` in `folder`, each with the seed and where it comes from.
///
/// # Errors
/// The file or its folder cannot be written.
pub fn write_csv<T: Serialize>(
    folder: &Path,
    name: &str,
    header: &[&str],
    records: &[T],
    seed: u32,
    provenance: &Provenance,
) -> Result<()> {
    check_folder(folder)?;
    results::table::write(&folder.join(name), false, |writer| {
        writer.write_record(header.iter().chain(&["seed", "commit", "machine"]))?;
        let whole = |record| (record, seed, &provenance.commit, &provenance.machine);
        records.iter().try_for_each(|record| writer.serialize(whole(record)))
    })
}

/// Makes a folder for tables, unless it is there.
///
/// # Errors
/// The folder cannot be made.
pub fn check_folder(folder: &Path) -> Result<(), WriteError> {
    std::fs::create_dir_all(folder).map_err(|source| WriteError { path: folder.to_owned(), source })
}
