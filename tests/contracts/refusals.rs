//! Contracts that stages rely on, and refusals where they do not hold.

use std::sync::Arc;

use halflight::bvh::{Bvh, BvhError};
use halflight::certificate::{Certificate, Region};
use halflight::config::{PipelineConfig, RefinerConfig, UpsamplerConfig};
use halflight::fragment::{FragmentError, Fragments, Sample};
use halflight::frame::Frame;
use halflight::mask::{MaskBatch, Purpose};
use halflight::pipeline::PipelineError;
use halflight::prepared::PreparedScene;
use halflight::refine::{DiscontinuityLimits, Lattice, LatticeConfig};
use halflight::scene::Scene;
use halflight::stages::{RefineOutput, Refiner, Visibility};
use halflight::upsample;
use halflight_tests::{Stage, blocker_over_floor};

#[test]
fn a_bvh_over_another_mesh_is_refused() {
    let stage = Stage::new(blocker_over_floor()).unwrap();
    let larger = Stage::bundled("contact").unwrap();
    let mut moved = (*stage.scene).clone();
    Arc::make_mut(&mut moved.mesh).positions[0].y += 0.25;
    let together = |scene: &Scene, bvh: &Arc<Bvh>| PreparedScene::with_bvh(scene.clone(), Arc::clone(bvh));
    together(&stage.scene, &stage.bvh).unwrap();
    for (scene, bvh) in [(&*stage.scene, &larger.bvh), (&*larger.scene, &stage.bvh), (&moved, &stage.bvh)] {
        assert!(matches!(together(scene, bvh), Err(BvhError::Foreign)));
    }
    let mut broken = moved.clone();
    Arc::make_mut(&mut broken.mesh).triangles[0][0] = 1000;
    assert!(matches!(together(&broken, &stage.bvh), Err(BvhError::Mesh(_))));
    // A mesh with other triangles, or with none that exist, cannot be followed.
    assert!(stage.prepared.moved((*larger.scene).clone()).is_err() && stage.prepared.moved(broken).is_err());
    let followed = stage.prepared.moved(moved.clone()).unwrap();
    assert!(followed.bvh().is_over(&moved.mesh) && !followed.bvh().is_over(&stage.scene.mesh));
    // Lights and cameras that move share the BVH.
    let lit = stage.prepared.moved(Scene { lights: Vec::new(), ..(*stage.scene).clone() }).unwrap();
    assert!(Arc::ptr_eq(lit.bvh(), stage.prepared.bvh()));
}

#[test]
fn refiner_and_upsampler_end_surfaces_at_the_same_limits() {
    let stage = Stage::bundled("atrium").unwrap();
    let discontinuity = DiscontinuityLimits { crease_deg: 80.0, step_px: 40.0 };
    let lattice = LatticeConfig { discontinuity, error: 0.2, ..LatticeConfig::default() };
    let config = PipelineConfig {
        width: 160,
        height: 120,
        refiner: RefinerConfig::Lattice(lattice),
        upsampler: UpsamplerConfig::Lattice(Default::default()),
        ..PipelineConfig::default()
    };
    let by_hand = |limits: DiscontinuityLimits| {
        let upsampler =
            upsample::LatticeConfig { discontinuity: limits, ..upsample::LatticeConfig::default() };
        let builder = stage.builder().size(160, 120).refiner(Lattice::new(lattice));
        let mut pipeline = builder.upsampler(upsample::Lattice::new(upsampler)).build().unwrap();
        pipeline.render().unwrap().irradiance.clone()
    };
    let found = stage.render(&config).unwrap().irradiance;
    assert!(found == by_hand(discontinuity));
    assert!(found != by_hand(DiscontinuityLimits::default()), "the limits matter here");
}

/// Backend that certifies everything as fully lit.
struct Bright;

impl Visibility for Bright {
    fn masks(&mut self, _frame: &Frame, batch: &mut MaskBatch) {
        let parts = batch.parts();
        parts.visible.copy_from_slice(parts.wanted);
    }

    fn certify(
        &mut self,
        _frame: &Frame,
        _light: u32,
        regions: &[Region],
        certificates: &mut Vec<Certificate>,
    ) {
        certificates.clear();
        certificates.resize(regions.len(), Certificate::Lit);
    }
}

#[test]
fn a_backend_from_outside_can_certify() {
    let stage = Stage::new(blocker_over_floor()).unwrap();
    let lattice = Lattice::new(LatticeConfig { certify: true, ..LatticeConfig::default() });
    let builder = stage.builder().size(64, 48).refiner(lattice).visibility(Bright);
    let certificates = builder.build().unwrap().render().unwrap().stats.certified;
    assert!(certificates.lit > 0 && certificates.umbra == 0 && certificates.bounded == 0, "{certificates:?}");
}

/// Refiner with one cell over the whole image, and a number of additional ones.
struct Cells(u32);

impl Refiner for Cells {
    fn refine(
        &mut self,
        frame: &Frame,
        _: u32,
        visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) -> RefineOutput<'_> {
        let batch = fragments.open_batch(frame.pattern, Purpose::Final);
        visibility.masks(frame, fragments.batch_mut(batch));
        let sample = Sample { probes: 0, ..Sample::of_pixel(0, frame.gbuffer.width, 6, batch, 0) };
        let sample = fragments.push_sample(sample);
        for _ in 0..self.0 {
            fragments.push_cell(6, 0, 0, &[sample]);
        }
        RefineOutput::default()
    }
}

#[test]
fn receivers_in_no_cell_or_in_two_are_refused() {
    let stage = Stage::new(blocker_over_floor()).unwrap();
    let error = |cells: u32| {
        let builder = stage.builder().size(64, 48).refiner(Cells(cells));
        builder.build().unwrap().render().err()
    };
    assert!(error(1).is_none());
    let missing = error(0);
    let uncovered = PipelineError::Fragments(FragmentError::Uncovered { pixel: 0 });
    assert_eq!(
        std::mem::discriminant(missing.as_ref().unwrap()),
        std::mem::discriminant(&uncovered),
        "{missing:?}"
    );
    assert!(missing.unwrap().to_string().contains("none of the refiner's cells"));
    assert!(error(2).unwrap().to_string().contains("more than one of the refiner's cells"));
}
