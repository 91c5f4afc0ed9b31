//! Statistics of a frame: as JSON, and in words.

use halflight_core::stats::{
    AntialiasCounts, CertificateCounts, FragmentCounts, FrameStats, IndirectCounts, RayCounts, StageTimes,
    VisibilityStats,
};
use halflight_cpu::config::{Named, PipelineConfig};
use serde::Serialize;

use crate::moment::Moment;
use crate::voxel_errors::VoxelFailures;

/// Configuration, counts and times of a frame, as JSON.
#[derive(Serialize)]
pub(crate) struct Statistics<'a> {
    config: &'a PipelineConfig,
    #[serde(flatten)]
    moment: Option<Moment>,
    fragments: &'a FragmentCounts,
    rays: &'a RayCounts,
    visibility: &'a VisibilityStats,
    certified: &'a CertificateCounts,
    antialias: &'a AntialiasCounts,
    indirect: &'a IndirectCounts,
    #[serde(skip_serializing_if = "Option::is_none")]
    expected_nmse2: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    voxel_failures: Option<VoxelFailures>,
    stages_ms: &'a StageTimes,
    total_ms: f64,
    build_ms: f64,
    peak_bytes: u64,
}

impl<'a> Statistics<'a> {
    pub(crate) fn new(
        config: &'a PipelineConfig,
        moment: Option<Moment>,
        stats: &'a FrameStats,
        voxel_failures: Option<VoxelFailures>,
        build_ms: f64,
    ) -> Self {
        let FrameStats {
            fragments,
            rays,
            visibility,
            certified,
            antialias,
            indirect,
            expected_nmse2,
            stages_ms,
            total_ms,
            peak_bytes,
            ..
        } = stats;
        Self {
            config,
            moment,
            fragments,
            rays,
            visibility,
            certified,
            antialias,
            indirect,
            expected_nmse2: *expected_nmse2,
            voxel_failures,
            stages_ms,
            total_ms: *total_ms,
            build_ms,
            peak_bytes: *peak_bytes,
        }
    }
}

/// Returns a short account for people.
pub(crate) fn summary(scene: &str, config: &PipelineConfig, stats: &FrameStats, build_ms: f64) -> String {
    let StageTimes {
        gbuffer,
        pyramid,
        refine,
        visibility,
        certify,
        irradiance,
        upsample,
        compose,
        specular,
        indirect,
        antialias,
        ..
    } = stats.stages_ms;
    let stages = [
        ("gbuffer", gbuffer),
        ("pyramid", pyramid),
        ("refine", refine),
        ("visibility", visibility),
        ("certify", certify),
        ("irradiance", irradiance),
        ("upsample", upsample),
        ("compose", compose),
        ("specular", specular),
        ("indirect", indirect),
        ("antialias", antialias),
        ("total", stats.total_ms),
    ];
    let PipelineConfig { width, height, refiner, visibility, upsampler, sampling, .. } = config;
    let mut lines = vec![format!(
        "{scene}, {width}x{height}: {}, {}, {}, {} light samples",
        refiner.name(),
        visibility.name(),
        upsampler.name(),
        sampling.count
    )];
    lines.extend(stages.iter().map(|(name, ms)| format!("  {name:<10} {ms:>9.1} ms")));
    let by_level = |counts: &[u64]| {
        let used = counts.iter().rposition(|&count| count > 0).map_or(0, |last| last + 1);
        counts[..used].iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
    };
    let FragmentCounts { total, per_level, cells, .. } = &stats.fragments;
    lines.push(format!("  fragments  {total} (by level: {})", by_level(per_level)));
    if cells != per_level && cells.iter().any(|&count| count > 0) {
        lines.push(format!("  cells      {} (by level: {})", cells.iter().sum::<u64>(), by_level(cells)));
    }
    let RayCounts { refine, last, specular, indirect, skipped, total, .. } = stats.rays;
    lines.push(format!(
        "  rays       {total} ({refine} to refine, {last} final, {specular} specular, {indirect} indirect; {skipped} skipped)"
    ));
    let VisibilityStats { prepare_ms, lit, umbra, spared, listed, walked, left_to_rays, pairs, kept, .. } =
        stats.visibility;
    if stats.visibility.receivers() > 0 {
        lines.push(format!(
            "  beams      {listed} receivers by shared lists, {walked} by walks, {left_to_rays} left to rays; certified: {lit} \
             lit, {umbra} umbra, {spared} rays spared"
        ));
    }
    if pairs > 0 {
        lines.push(format!("  pairs      {pairs}, {kept} kept; binned in {prepare_ms:.1} ms"));
    }
    let CertificateCounts { lit, umbra, bounded, traced, .. } = stats.certified;
    let pixels = lit + umbra + bounded + traced;
    if pixels > 0 {
        let share = |count: u64| 100.0 * count as f64 / pixels as f64;
        lines.push(format!(
            "  certified  {:.1} % of the receivers: {:.1} % lit, {:.1} % umbra, {:.1} % bounded; the others traced",
            share(lit + umbra + bounded),
            share(lit),
            share(umbra),
            share(bounded)
        ));
    }
    let AntialiasCounts { edge_pixels, resolved_pixels, sub_samples, masks, .. } = stats.antialias;
    if edge_pixels > 0 {
        lines.push(format!(
            "  edges      {edge_pixels} pixels, {resolved_pixels} of several surfaces; {sub_samples} sub-samples, {masks} with masks of \
             their own"
        ));
    }
    let IndirectCounts { points, lit, records, place_ms, light_ms, transport_ms, lookup_ms, .. } =
        stats.indirect;
    if points > 0 {
        lines.push(format!(
            "  points     {points} placed in {place_ms:.1} ms; {lit} lit sides in {light_ms:.1} ms; {records} records, transport in \
             {transport_ms:.1} ms; look-up in {lookup_ms:.1} ms"
        ));
    }
    if let Some(error) = stats.expected_nmse2 {
        lines.push(format!("  expected   NMSE2 {error:.1e}"));
    }
    // Memory of a GPU is not counted.
    if stats.peak_bytes > 0 {
        lines.push(format!("  memory     {:.1} MiB", stats.peak_bytes as f64 / f64::from(1 << 20)));
    }
    lines.push(format!("  BVH  built in {build_ms:.1} ms"));
    lines.join("\n")
}
