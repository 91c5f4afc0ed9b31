//! Finished rows: their line of `results.csv`, and what the report needs beside it.

use std::path::Path;

use anyhow::Result;
use halflight_core::fragment::LEVELS;
use serde::{Deserialize, Serialize};

use super::frames::{FrameError, FrameWork};

/// Factor by which a reference's own error must lie below an error measured against it.
pub const NOISE_MARGIN: f64 = 16.0;

/// Line of `results.csv`; fields are columns, in this order.
///
/// Times are medians over repeated frames, in ms. Errors are those of the linear irradiance over receiver pixels, as
/// [`Comparison`](halflight_metrics::Comparison) defines them; `psnr` is empty where the images are equal.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Name of the experiment.
    pub experiment: String,
    /// Name of the scene.
    pub scene: String,
    /// Triangles in the scene.
    pub triangles: u64,
    /// Image width, pixels.
    pub width: u32,
    /// Image height, pixels.
    pub height: u32,
    /// Refiner, or rival.
    #[serde(deserialize_with = "crate::experiment::refiner_name")]
    pub refiner: String,
    /// Constants that the experiment sets: `name=value`, separated by `;`.
    pub parameters: String,
    /// Visibility backend.
    pub visibility: String,
    /// Upsampler.
    pub upsampler: String,
    /// Quantity that is interpolated.
    pub shading: String,
    /// Light samples of a full mask.
    pub samples: u32,
    /// Placement of light samples in their strata.
    pub pattern: String,
    /// Sharing of light samples.
    pub sharing: String,
    /// Factor on the lights' edges.
    pub light_scale: f32,
    /// Seed.
    pub seed: u32,
    /// Device that rendered: `cpu`, or `gpu` with the adapter's name.
    #[serde(default = "super::provenance::cpu")]
    pub device: String,
    /// Worker threads.
    pub threads: usize,
    /// Fragments.
    pub fragments: u64,
    /// Shadow rays traced.
    pub rays: u64,
    /// Shadow rays for refinement.
    pub rays_refine: u64,
    /// Shadow rays for irradiance alone.
    pub rays_final: u64,
    /// Rays not traced because the sample lies below a horizon.
    pub rays_skipped: u64,
    /// Time of the G-buffer.
    pub gbuffer_ms: f64,
    /// Time of the discontinuity pyramid.
    pub pyramid_ms: f64,
    /// Time of refinement without visibility.
    pub refine_ms: f64,
    /// Time of visibility.
    pub visibility_ms: f64,
    /// Time of irradiance: values of the samples.
    pub irradiance_ms: f64,
    /// Time of upsampling.
    pub upsample_ms: f64,
    /// Time of composition.
    pub compose_ms: f64,
    /// Time of the whole frame.
    pub total_ms: f64,
    /// Σ (a − b)².
    pub sse: f64,
    /// Koa17's normalised error, after division by the peak.
    pub nmse: f64,
    /// Σ (a − b)² / Σ b².
    pub nmse2: f64,
    /// Mean relative squared error.
    pub relmse: f64,
    /// Peak signal-to-noise ratio, dB.
    pub psnr: Option<f64>,
    /// Structural similarity.
    pub ssim: f64,
    /// Mean LDR-FLIP.
    pub flip: f64,
    /// 99th percentile of LDR-FLIP over the pixels; empty in rows of programs that did not measure it.
    pub flip_p99: Option<f64>,
    /// Grain of the penumbra; empty where no pixel lies in one, and in rows of programs that did not measure it.
    pub grain: Option<f64>,
    /// Estimated NMSE₂ of the reference itself.
    pub reference_noise: f64,
    /// Estimated grain of the reference itself.
    pub reference_grain: Option<f64>,
    /// Commit of the program.
    pub commit: String,
    /// Processor, cores and system.
    pub machine: String,
    /// Time to prepare the backend, once a frame; part of `visibility_ms`.
    #[serde(default)]
    pub prepare_ms: f64,
    /// Receivers certified to see all of the light; these counts are those of [`VisibilityStats`](halflight_core::stats::VisibilityStats).
    #[serde(default)]
    pub lit: u64,
    /// Receivers certified to see nothing of the light.
    #[serde(default)]
    pub umbra: u64,
    /// Rays that these certificates spared.
    #[serde(default)]
    pub spared: u64,
    /// Receivers that shared a list of triangles.
    #[serde(default)]
    pub listed: u64,
    /// Receivers that walked the BVH by themselves.
    #[serde(default)]
    pub walked: u64,
    /// Receivers left to rays.
    #[serde(default)]
    pub left_to_rays: u64,
    /// Triangle entries in the framebuffer's cells.
    #[serde(default)]
    pub entries: u64,
    /// Pairs of a receiver and a triangle that shared a cell.
    #[serde(default)]
    pub pairs: u64,
    /// Pairs left after rejection.
    #[serde(default)]
    pub kept: u64,
    /// Pairs whose triangle hides a sample from the receiver; 0 where they are not counted.
    #[serde(default)]
    pub relevant: u64,
    /// Receivers that looked at all triangles.
    #[serde(default)]
    pub unprojected: u64,
    /// Mean visible fraction that voxel marching takes away where it is too dark, over all receivers. This column and the
    /// following six are empty where rows are not `per-pixel` and `voxel`.
    pub false_shadow: Option<f64>,
    /// Mean visible fraction that voxel marching adds where it is too bright, over all receivers.
    pub false_light: Option<f64>,
    /// Share of the receivers whose visible fraction is off by more than [`OFF`](crate::reference::voxel_errors::OFF).
    pub off_share: Option<f64>,
    /// Receivers that are off since their rays end at the receiver itself.
    pub self_occlusion: Option<u64>,
    /// Receivers that are off behind geometry thinner than its voxels.
    pub thickness: Option<u64>,
    /// Receivers that are off since their occluder lies outside the grid.
    pub out_of_view: Option<u64>,
    /// Receivers that are off since their rays missed what lies in the grid.
    pub missed: Option<u64>,
    /// Mean flicker from frame to frame along the scene's animation, as in [`Flicker`](halflight_metrics::Flicker), in
    /// the mean over frames. This column and the following two are empty where the experiment does not ask for flicker.
    pub flicker_mean: Option<f64>,
    /// 99th percentile of flicker over the pixels, in the mean over frames.
    pub flicker_p99: Option<f64>,
    /// Mean NMSE₂ over these frames.
    pub flicker_nmse2: Option<f64>,
    /// NMSE₂ that the refiner expects, where it has an error target.
    pub expected_nmse2: Option<f64>,
    /// Receiver pixels in cells certified to be lit. This column and the following four are empty where no certificates are asked for.
    #[serde(alias = "proved_lit")]
    pub certified_lit: Option<u64>,
    /// Receiver pixels certified to be in the umbra.
    #[serde(alias = "proved_umbra")]
    pub certified_umbra: Option<u64>,
    /// Receiver pixels whose visible fraction was certified to vary little.
    #[serde(alias = "proved_bounded")]
    pub certified_bounded: Option<u64>,
    /// Receiver pixels that were traced.
    pub traced: Option<u64>,
    /// Time of the certificates.
    #[serde(alias = "prove_ms")]
    pub certify_ms: Option<f64>,
}

/// Finished row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finished {
    /// Name of the setting in file names.
    pub setting: String,
    /// Name of the row in file names.
    pub row: String,
    /// Name of the fragment map in file names, which rows with the same fragments share.
    pub fragments: String,
    /// Name for people.
    pub label: String,
    /// SSE of the images divided by the reference's peak.
    pub normalised_sse: f64,
    /// Errors against a second reference with as many samples as the paper's.
    pub paper: Option<PaperError>,
    /// Fragments of each level, 0 first.
    pub per_level: [u64; LEVELS],
    /// Left and top of the [`WINDOW`](super::pictures::WINDOW) in which the picture differs most from the reference's, pixels.
    #[serde(default)]
    pub worst: [u32; 2],
    /// Frames along the scene's animation, where the experiment asks for them.
    #[serde(default)]
    pub frames: Vec<FrameError>,
    /// Work along the scene's animation, where the experiment asks for it.
    #[serde(default)]
    pub path: Vec<FrameWork>,
    /// Line of `results.csv`.
    pub record: Record,
}

/// Errors as a paper measures them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PaperError {
    /// SSE of the images divided by the reference's peak.
    pub sse: f64,
    /// SSE over the sum of the reference, both divided by its peak.
    pub nmse: f64,
}

impl Record {
    /// Returns the scene's name without changed parameters.
    pub fn scene_name(&self) -> &str {
        self.scene.split(' ').next().unwrap_or_default()
    }

    /// Returns whether the reference is too noisy for this row's error to be believed.
    pub fn near_noise(&self) -> bool {
        self.reference_noise * NOISE_MARGIN > self.nmse2
    }
}

/// Writes `results.csv`.
///
/// # Errors
/// The file cannot be written.
pub fn write_csv<'a>(path: &Path, records: impl IntoIterator<Item = &'a Record>) -> Result<()> {
    super::table::write(path, true, |writer| {
        records.into_iter().try_for_each(|record| writer.serialize(record))
    })
}

/// Reads a `results.csv`.
///
/// # Errors
/// The file cannot be read, or a line does not have the columns of a [`Record`].
pub fn read_csv(path: &Path) -> Result<Vec<Record>> {
    let text = fs_err::read(path)?;
    Ok(csv::Reader::from_reader(text.as_slice()).deserialize().collect::<Result<_, _>>()?)
}

#[cfg(test)]
pub(crate) mod tests {
    use halflight_core::stats::FrameStats;
    use halflight_cpu::config::{Named as _, RefinerConfig};

    use super::*;
    use crate::rivals::Rival;

    /// A made-up row; `time` and `error` are all that charts look at.
    pub(crate) fn finished(refiner: &str, upsampler: &str, time: f64, error: f64) -> Finished {
        Finished {
            setting: "hall".to_string(),
            row: format!("{refiner}-{upsampler}"),
            fragments: refiner.to_string(),
            label: format!("{refiner} · {upsampler} · ratio"),
            normalised_sse: 0.25,
            paper: None,
            per_level: [3; LEVELS],
            worst: [8, 4],
            frames: Vec::new(),
            path: Vec::new(),
            record: Record {
                experiment: "made-up".to_string(),
                scene: "hall".to_string(),
                triangles: 12,
                width: 64,
                height: 48,
                refiner: refiner.to_string(),
                visibility: "bvh".to_string(),
                upsampler: upsampler.to_string(),
                shading: "ratio".to_string(),
                samples: 64,
                pattern: "jittered".to_string(),
                sharing: "fragment".to_string(),
                light_scale: 1.0,
                device: "cpu".to_string(),
                threads: 2,
                fragments: 100,
                rays: (time * 1e3) as u64,
                gbuffer_ms: 1.25,
                visibility_ms: 0.7,
                upsample_ms: 0.2,
                total_ms: time,
                sse: error * 10.0,
                nmse: error,
                nmse2: error,
                relmse: 1.0 / 3.0,
                psnr: Some(41.5),
                flip_p99: Some(error.sqrt()),
                grain: Some(2.0 * error.sqrt()),
                reference_noise: 1e-7,
                commit: "abc1234".to_string(),
                machine: "a processor, 2 cores, linux".to_string(),
                prepare_ms: 0.25,
                lit: 1,
                pairs: 80,
                kept: 40,
                relevant: 10,
                ..Record::default()
            },
        }
    }

    #[test]
    fn csv_comes_back_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results.csv");
        let mut equal = finished("per-pixel", "bilinear", 3.0, 0.0).record;
        equal.psnr = None;
        (equal.flicker_mean, equal.flicker_nmse2) = (Some(1e-3 / 3.0), Some(0.0));
        (equal.false_shadow, equal.off_share, equal.missed) = (Some(1.0 / 3.0), Some(0.0), Some(7));
        (equal.flip_p99, equal.grain) = (Some(1.0 / 3.0), Some(1e-300));
        equal.parameters = "a=1;b=\"x\", y".to_string();
        let records = vec![finished("nichols", "delaunay", 0.1 + 0.2, 1e-300).record, equal];
        write_csv(&path, &records).unwrap();
        let header = std::fs::read_to_string(&path).unwrap().lines().next().unwrap().to_string();
        let read = read_csv(&path).unwrap();
        assert_eq!(read, records);
        assert_eq!(
            header,
            "experiment,scene,triangles,width,height,refiner,parameters,visibility,upsampler,shading,samples,\
             pattern,sharing,light_scale,seed,device,threads,fragments,rays,rays_refine,rays_final,rays_skipped,\
             gbuffer_ms,pyramid_ms,refine_ms,visibility_ms,irradiance_ms,upsample_ms,compose_ms,total_ms,\
             sse,nmse,nmse2,relmse,psnr,ssim,flip,flip_p99,grain,reference_noise,reference_grain,commit,machine,\
             prepare_ms,lit,umbra,spared,listed,walked,left_to_rays,entries,pairs,kept,relevant,unprojected,\
             false_shadow,false_light,off_share,self_occlusion,thickness,out_of_view,missed,\
             flicker_mean,flicker_p99,flicker_nmse2,\
             expected_nmse2,certified_lit,certified_umbra,certified_bounded,traced,certify_ms"
        );
    }

    #[test]
    fn tables_of_older_programs_can_be_read() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../results");
        let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let tables: Vec<_> = files.filter(|path| path.extension().is_some_and(|end| end == "csv")).collect();
        assert!(!tables.is_empty());
        for table in tables {
            let rows = read_csv(&table).unwrap_or_else(|fault| panic!("{}: {fault}", table.display()));
            assert!(rows.iter().all(|row| row.total_ms > 0.0), "{}", table.display());
            let names = [RefinerConfig::NAMES, Rival::NAMES].concat();
            let known = |row: &Record| names.contains(&row.refiner.as_str());
            assert!(rows.iter().all(known), "{}", table.display());
            let measured = std::fs::read_to_string(&table).unwrap().contains("flip_p99,grain");
            assert!(
                rows.iter()
                    .all(|row| row.flip_p99.is_some() == measured && (measured || row.grain.is_none())),
                "{}",
                table.display()
            );
        }
    }

    #[test]
    fn former_names_are_read() {
        let table = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../results/targets.csv");
        let certified = |row: &Record| {
            let counts = [row.certified_lit, row.certified_umbra, row.certified_bounded];
            counts.iter().all(Option::is_some) && row.certify_ms.is_some()
        };
        assert!(read_csv(&table).unwrap().iter().any(certified));
        let mut stats = FrameStats::default();
        (stats.certified.lit, stats.stages_ms.certify) = (3, 0.5);
        let today = serde_json::to_string(&stats).unwrap();
        let before = today.replace("\"certified\"", "\"proofs\"").replace("\"certify\"", "\"prove\"");
        assert_ne!(before, today);
        assert_eq!(serde_json::from_str::<FrameStats>(&before).unwrap(), stats);
    }

    #[test]
    fn errors_near_the_reference_s_noise_are_flagged() {
        assert!(!finished("per-pixel", "bilinear", 1.0, 17e-7).record.near_noise());
        assert!(finished("per-pixel", "bilinear", 1.0, 15e-7).record.near_noise());
    }
}
