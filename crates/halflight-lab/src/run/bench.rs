//! Rows of one setting, timed in turn and measured.

use std::path::Path;

use anyhow::{Context as _, Result};
use halflight_core::stats::FrameStats;
use halflight_cpu::config::{RefinerConfig, VisibilityConfig};
use halflight_image::{memory, picture};
use halflight_metrics::{squared_error_picture, write_png};
use rayon::prelude::*;

use super::device::{Device, Machine};
use super::loaded::Loaded;
use super::measured::Measured;
use super::progress::Progress;
use super::state::State;
use super::timing;
use super::truth::Truth;
use super::window;
use crate::experiment::Experiment;
use crate::experiment::plan::{Row, Setting};
use crate::reference::voxel_errors::{Failures, failures};
use crate::results::{Along, Finished, PaperError, PictureKind, Provenance};

/// Bytes up to which pipelines are held together, and so timed in turn; half of what can be had where that is less.
const GROUP_BYTES: u64 = 3 << 30;

/// Pipeline of a row that is timed.
struct Running<'a> {
    row: &'a Row,
    machine: Machine,
    times: Vec<FrameStats>,
    along: &'a Along,
}

/// Rows of one setting, side by side.
pub(super) struct Bench<'a> {
    pub(super) experiment: &'a Experiment,
    pub(super) device: &'a Device,
    pub(super) provenance: &'a Provenance,
    pub(super) setting: &'a Setting,
    pub(super) scene: &'a Loaded,
    pub(super) truth: &'a Truth,
    pub(super) folder: &'a Path,
}

impl Bench<'_> {
    pub(super) fn run(&self, rows: &[(&Row, Along)], state: &mut State, progress: &Progress) -> Result<()> {
        let mut left = rows.iter();
        loop {
            let most = memory::available().map_or(GROUP_BYTES, |bytes| GROUP_BYTES.min(bytes / 2));
            let mut group: Vec<Running> = Vec::new();
            let mut bytes = 0;
            for (row, along) in left.by_ref() {
                progress.now(format!("{}: warming {}", self.setting.label, row.label()));
                let Some(running) = self.warm(row, along)? else {
                    progress.say(&format!("{}: {} has no such stages", row.label(), self.device.name()));
                    progress.advance(1);
                    continue;
                };
                bytes += running
                    .machine
                    .stats()
                    .peak_bytes
                    .saturating_sub(self.scene.prepared.bvh().bytes() as u64);
                group.push(running);
                if bytes > most {
                    break;
                }
            }
            if group.is_empty() {
                return Ok(());
            }
            // Round and round: whatever slows the machine for a while slows all rows alike.
            let of = self.experiment.repetitions_of(self.setting.scene);
            for repetition in 1..=of {
                for running in &mut group {
                    progress.now(format!(
                        "{}: round {repetition} of {of}, {}",
                        self.setting.label,
                        running.row.label()
                    ));
                    let stats = running.machine.render(running.row)?;
                    running.times.push(stats);
                }
            }
            progress.now(format!("{}: measuring {} rows", self.setting.label, group.len()));
            group.iter_mut().try_for_each(|running| running.machine.fetch())?;
            let finished: Vec<Finished> =
                group.into_par_iter().map(|running| self.measure(&running)).collect::<Result<_, _>>()?;
            for row in finished {
                state.append(row)?;
                progress.advance(1);
            }
        }
    }

    /// Builds a pipeline and renders the frame that is not timed.
    fn warm<'r>(&self, row: &'r Row, along: &'r Along) -> Result<Option<Running<'r>>> {
        let Some(mut machine) = self.device.machine(row, &self.truth.scene)? else {
            return Ok(None);
        };
        machine.render(row)?;
        Ok(Some(Running { row, machine, times: Vec::new(), along }))
    }

    fn measure(&self, running: &Running) -> Result<Finished> {
        let (row, irradiance, stats) = (running.row, running.machine.irradiance(), running.machine.stats());
        let (errors, normalised_sse) =
            self.truth.errors(row, irradiance, &self.truth.reference.irradiance)?;
        let paper = match &self.truth.paper {
            Some(reference) => {
                let (errors, sse) = self.truth.errors(row, irradiance, reference)?;
                Some(PaperError { sse, nmse: errors.nmse })
            }
            None => None,
        };
        let failures = self.failures(row)?;
        let measured = Measured {
            experiment: &self.experiment.name,
            scene: &self.scene.name,
            triangles: self.scene.prepared.bvh().triangle_count(),
            setting: self.setting,
            row,
            stats,
            times: timing::medians(&running.times),
            errors,
            failures: failures.as_ref(),
            frames: &running.along.errors,
            reference: &self.truth.reference,
            provenance: self.provenance,
        };
        let mut finished = Finished {
            setting: self.setting.slug.clone(),
            row: row.slug(),
            fragments: row.fragments_slug(),
            label: row.label(),
            normalised_sse,
            paper,
            per_level: stats.fragments.per_level,
            worst: [0, 0],
            frames: running.along.errors.clone(),
            path: running.along.work.clone(),
            record: measured.record(),
        };
        finished.worst = self.write_pictures(running, &finished)?;
        if let Some(failures) = failures {
            let [width, height] = self.setting.size;
            let path = self.folder.join(PictureKind::Failures.file(&finished));
            write_png(&path, width, height, &failures.image)?;
        }
        Ok(finished)
    }

    /// Returns where voxel marching fails, for rows that ask it about every pixel.
    fn failures(&self, row: &Row) -> Result<Option<Failures>> {
        let (RefinerConfig::PerPixel, VisibilityConfig::Voxel(voxel)) =
            (row.config.refiner, row.config.visibility)
        else {
            return Ok(None);
        };
        let (scene, gbuffer) = (&self.truth.scene, &self.truth.gbuffer);
        let found = failures(scene, gbuffer, voxel, row.config.sampling, row.config.seed);
        found.map(Some).with_context(|| row.named())
    }

    /// Writes a row's pictures and returns where they differ most from the reference's.
    fn write_pictures(&self, running: &Running, finished: &Finished) -> Result<[u32; 2]> {
        let irradiance = running.machine.irradiance();
        let (image, reference) =
            (self.truth.image(irradiance)?, self.truth.image(&self.truth.reference.irradiance)?);
        let (width, height) = (image.width(), image.height());
        let [picture, fragments, error, squared, _] =
            PictureKind::ALL.map(|kind| self.folder.join(kind.file(finished)));
        let seen = self.truth.picture(irradiance);
        write_png(&picture, width, height, &seen)?;
        if !fragments.is_file() {
            let map = running.machine.fragment_map(&self.truth.gbuffer);
            write_png(&fragments, width, height, &map)?;
        }
        let map = picture::error(image, reference, self.experiment.error_scale)?;
        write_png(&error, width, height, &map)?;
        if let Some(factor) = self.experiment.squared_error_factor {
            let map = squared_error_picture(image, reference, factor)?;
            write_png(&squared, width, height, &map)?;
        }
        let converged = self.truth.picture(&self.truth.reference.irradiance);
        Ok(window::worst(width, height, &seen, &converged))
    }
}
