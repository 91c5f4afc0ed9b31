//! Exactness: masks of all exact backends, held against each other and against brute force bit for bit.
//!
//! [`check`] asks them about the receivers of images of a scene; [`primary`] holds what pixels see against brute force;
//! [`certificates`] tries to break what beams prove without asking.

pub mod certificates;
pub mod primary;
mod truth;

use std::path::Path;
use std::sync::Arc;

use halflight_core::frame::{Frame, Sharing};
use halflight_core::gbuffer::GBuffer;
use halflight_core::mask::{MaskBatch, Purpose};
use halflight_core::pattern::{Pattern, PatternKind};
use halflight_core::pyramid::Pyramid;
use halflight_core::scene::Scene;
use halflight_core::stages::Visibility;
use halflight_cpu::bvh::{Bvh, BvhError};
use halflight_cpu::config::{Named, VisibilityConfig};
use halflight_cpu::gbuffer;
use halflight_cpu::horizon;
use halflight_cpu::pipeline::PipelineError;
use halflight_metrics::{WriteError, write_file};
use halflight_scene::SceneError;
use serde::Serialize;

use crate::results::Provenance;

/// The scenes that are compared where none is named.
pub const SCENES: [&str; 5] = ["atrium", "nave", "hairball", "tree", "soup"];

/// The patterns of all comparisons; 4D rasterization cannot answer the last.
const PATTERNS: [Pattern; 3] = [
    Pattern { kind: PatternKind::Grid, columns: 8, rows: 8 },
    Pattern { kind: PatternKind::ShiftedRows, columns: 16, rows: 16 },
    Pattern { kind: PatternKind::Jittered, columns: 8, rows: 8 },
];

/// Why backends cannot be compared.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExactnessError {
    /// A scene cannot be loaded.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A BVH cannot be built.
    #[error(transparent)]
    Bvh(#[from] BvhError),
    /// A backend cannot be set up.
    #[error(transparent)]
    Backend(#[from] PipelineError),
    /// No receiver in view has the light above its horizon.
    #[error("nothing in view faces the light, so that there is nothing to compare")]
    Nothing,
    /// A table cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A table cannot be put into words.
    #[error(transparent)]
    Csv(#[from] csv::Error),
}

/// How much is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Pairs of a receiver and a light sample that every backend is asked for at least.
    pub pairs: u64,
    /// Pairs of these that brute force is asked for at least.
    pub brute_force: u64,
    /// Seed of the light samples and of the choice of receivers for brute force.
    pub seed: u32,
}

/// A backend and what it is called.
pub struct Backend {
    /// Its name in tables.
    pub name: &'static str,
    /// The backend.
    pub visibility: Box<dyn Visibility>,
}

/// The exact backends: `bvh`, which the others are held against, `raster4d`, `beam` and `auto`.
///
/// # Errors
/// One cannot be set up.
pub fn backends(bvh: &Arc<Bvh>) -> Result<Vec<Backend>, PipelineError> {
    let exact = VisibilityConfig::NAMES.iter().filter(|&&name| name != "voxel");
    exact
        .filter_map(|&name| VisibilityConfig::named(name).map(|config| (name, config)))
        .map(|(name, config)| Ok(Backend { name, visibility: config.stage(bvh)? }))
        .collect()
}

/// What one backend, or brute force, was found to say of a scene, against the first backend.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Agreement {
    /// The backend.
    pub name: &'static str,
    /// Pairs that were compared.
    pub pairs: u64,
    /// Pairs about which the two say different things.
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
/// [`ExactnessError::Nothing`] where an image has nothing to ask about.
pub fn check(
    scene: &Scene,
    bvh: &Bvh,
    backends: &mut [Backend],
    settings: &Settings,
    mut progress: impl FnMut(u64),
) -> Result<Vec<Agreement>, ExactnessError> {
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
            first.visibility.masks(&frame, &mut batch);
            let expected = batch.parts().visible.to_vec();
            for (backend, agreement) in others.iter_mut().zip(&mut agreements) {
                if backend.visibility.supports(pattern).is_ok() {
                    backend.visibility.masks(&frame, &mut batch);
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
            return Err(ExactnessError::Nothing);
        }
        if agreements.iter().all(|agreement| agreement.pairs >= settings.pairs) {
            break;
        }
        height += height / 4 + 1;
    }
    agreements.push(brute_force);
    Ok(agreements)
}

/// A query for every receiver in view, without samples below a horizon.
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

/// A row of the table: a backend in a scene.
#[derive(Clone, Debug, Serialize)]
pub struct Record {
    /// The scene.
    pub scene: String,
    /// Its triangles.
    pub triangles: usize,
    /// The backend that was compared with `bvh`.
    pub backend: &'static str,
    /// Pairs of a receiver and a light sample.
    pub pairs: u64,
    /// Pairs about which they differ.
    pub different: u64,
}

/// The rows as a table for people.
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
) -> Result<(), ExactnessError> {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    writer.write_record(header.iter().chain(&["seed", "commit", "machine"]))?;
    for record in records {
        writer.serialize((record, seed, &provenance.commit, &provenance.machine))?;
    }
    let bytes = writer.into_inner().map_err(|fault| csv::Error::from(fault.into_error()))?;
    check_folder(folder)?;
    write_file(&folder.join(name), &bytes)?;
    Ok(())
}

/// Makes a folder for tables, unless it is there.
///
/// # Errors
/// The folder cannot be made.
pub fn check_folder(folder: &Path) -> Result<(), WriteError> {
    std::fs::create_dir_all(folder).map_err(|source| WriteError { path: folder.to_owned(), source })
}
