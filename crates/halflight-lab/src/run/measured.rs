//! Records of measured rows.

use halflight_core::stats::{CertificateCounts, FrameStats};
use halflight_metrics::Comparison;

use super::timing::Medians;
use crate::experiment::plan::{Row, Setting, word};
use crate::reference::Reference;
use crate::reference::voxel_errors::Failures;
use crate::results::{FrameError, Means, Provenance, Record};

/// Measurements that a row's record is made of.
pub(crate) struct Measured<'a> {
    pub(crate) experiment: &'a str,
    pub(crate) scene: &'a str,
    pub(crate) triangles: usize,
    pub(crate) setting: &'a Setting,
    pub(crate) row: &'a Row,
    pub(crate) stats: &'a FrameStats,
    pub(crate) times: Medians,
    pub(crate) errors: Comparison,
    pub(crate) failures: Option<&'a Failures>,
    pub(crate) frames: &'a [FrameError],
    pub(crate) reference: &'a Reference,
    pub(crate) provenance: &'a Provenance,
}

impl Measured<'_> {
    pub(crate) fn record(&self) -> Record {
        let (config, stats, errors) = (&self.row.config, self.stats, &self.errors);
        let Medians { stages, prepare, total } = self.times;
        let [refiner, backend, upsampler] = self.row.stages();
        let flicker = Means::of(self.frames);
        let certified = (stats.certified != CertificateCounts::default()).then_some(stats.certified);
        let (visibility, causes) = (&stats.visibility, self.failures.map(|failures| failures.counts));
        Record {
            experiment: self.experiment.to_string(),
            scene: self.scene.to_string(),
            triangles: self.triangles as u64,
            width: config.width,
            height: config.height,
            refiner: refiner.to_string(),
            parameters: self.row.parameters.clone(),
            visibility: backend.to_string(),
            upsampler: upsampler.to_string(),
            shading: word(config.shading),
            samples: config.sampling.count,
            pattern: word(config.sampling.kind),
            sharing: word(config.sampling.sharing),
            light_scale: self.setting.light_scale,
            seed: config.seed,
            device: self.provenance.device.clone(),
            threads: self.provenance.threads,
            fragments: stats.fragments.total,
            rays: stats.rays.total,
            rays_refine: stats.rays.refine,
            rays_final: stats.rays.last,
            rays_skipped: stats.rays.skipped,
            gbuffer_ms: stages.gbuffer,
            pyramid_ms: stages.pyramid,
            refine_ms: stages.refine,
            visibility_ms: stages.visibility,
            irradiance_ms: stages.irradiance,
            upsample_ms: stages.upsample,
            compose_ms: stages.compose,
            total_ms: total,
            sse: errors.sse,
            nmse: errors.nmse,
            nmse2: errors.nmse2,
            relmse: errors.relmse,
            psnr: errors.psnr.is_finite().then_some(errors.psnr),
            ssim: errors.ssim,
            flip: errors.flip,
            flip_p99: Some(errors.flip_p99),
            grain: errors.grain,
            reference_noise: self.reference.noise_nmse2,
            reference_grain: self.reference.noise_grain,
            commit: self.provenance.commit.clone(),
            machine: self.provenance.machine.clone(),
            prepare_ms: prepare,
            lit: visibility.lit,
            umbra: visibility.umbra,
            spared: visibility.spared,
            listed: visibility.listed,
            walked: visibility.walked,
            left_to_rays: visibility.left_to_rays,
            entries: visibility.entries,
            pairs: visibility.pairs,
            kept: visibility.kept,
            relevant: visibility.relevant,
            unprojected: visibility.unprojected,
            false_shadow: self.failures.map(|failures| failures.false_shadow),
            false_light: self.failures.map(|failures| failures.false_light),
            off_share: self.failures.map(Failures::off_share),
            self_occlusion: causes.map(|counts| counts.self_occlusion),
            thickness: causes.map(|counts| counts.thickness),
            out_of_view: causes.map(|counts| counts.out_of_view),
            missed: causes.map(|counts| counts.missed),
            flicker_mean: flicker.map(|means| means.mean),
            flicker_p99: flicker.map(|means| means.p99),
            flicker_nmse2: flicker.map(|means| means.nmse2),
            expected_nmse2: stats.expected_nmse2,
            certified_lit: certified.map(|counts| counts.lit),
            certified_umbra: certified.map(|counts| counts.umbra),
            certified_bounded: certified.map(|counts| counts.bounded),
            traced: certified.map(|counts| counts.traced),
            certify_ms: certified.map(|_| stages.certify),
        }
    }
}
