//! Backend that supports only regular grids: refused when the pipeline is built, or by an error in the frame
//! if a refiner did not announce its patterns.

use halflight::config::{Named, RefinerConfig};
use halflight::fragment::Fragments;
use halflight::frame::{Frame, LightSampling, Sharing};
use halflight::mask::{MaskBatch, Purpose};
use halflight::pattern::{Pattern, PatternKind};
use halflight::pipeline::PipelineError;
use halflight::rays::BvhRays;
use halflight::stages::{RefineOutput, Refiner, Unsupported, Visibility};
use halflight_tests::{Stage, blocker_over_floor};

struct GridsOnly(BvhRays);

impl Visibility for GridsOnly {
    fn masks(&mut self, frame: &Frame, batch: &mut MaskBatch) {
        assert_eq!(batch.pattern().kind, PatternKind::Grid, "asked although it refuses");
        self.0.masks(frame, batch);
    }

    fn supports(&self, pattern: Pattern) -> Result<(), Unsupported> {
        match pattern.kind {
            PatternKind::Grid => Ok(()),
            _ => Err(Unsupported::new("grids-only", pattern, "only regular grids; choose the grid pattern")),
        }
    }
}

fn sampling(kind: PatternKind) -> LightSampling {
    LightSampling { count: 64, kind, sharing: Sharing::Frame }
}

#[test]
fn patterns_are_refused_when_the_pipeline_is_built() {
    let stage = Stage::new(blocker_over_floor()).unwrap();
    for &name in RefinerConfig::NAMES {
        let build = |kind| {
            let builder = stage.builder().size(64, 48).sampling(sampling(kind));
            let builder = builder.boxed_refiner(RefinerConfig::named(name).unwrap().stage());
            builder.visibility(GridsOnly(BvhRays::new(stage.bvh.clone()))).build()
        };
        for kind in [PatternKind::Jittered, PatternKind::ShiftedRows] {
            let Err(PipelineError::Unsupported(refusal)) = build(kind) else {
                panic!("{name} {kind:?} accepted")
            };
            assert_eq!((refusal.stage.as_str(), refusal.pattern.kind), ("grids-only", kind));
        }
        let mut pipeline = build(PatternKind::Grid).unwrap();
        assert!(pipeline.render().unwrap().irradiance.iter().any(|v| v.x > 0.0));
    }
}

/// Refiner with a pattern that it does not announce.
struct Secretive;

impl Refiner for Secretive {
    fn refine(
        &mut self,
        frame: &Frame,
        light: u32,
        visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) -> RefineOutput<'_> {
        let pattern = Pattern { kind: PatternKind::Jittered, ..frame.pattern };
        let batch = fragments.open_batch(pattern, Purpose::Refine);
        let receiver = (0..frame.gbuffer.pixels()).find_map(|pixel| frame.gbuffer.receiver(pixel)).unwrap();
        fragments.batch_mut(batch).push(receiver.origin, receiver.normal, 0, frame.shared_key(light), None);
        visibility.masks(frame, fragments.batch_mut(batch));
        RefineOutput::default()
    }
}

#[test]
fn an_unannounced_pattern_is_an_error_of_the_frame() {
    let stage = Stage::new(blocker_over_floor()).unwrap();
    let builder = stage.builder().size(16, 16).sampling(sampling(PatternKind::Grid)).refiner(Secretive);
    let mut pipeline = builder.visibility(GridsOnly(BvhRays::new(stage.bvh.clone()))).build().unwrap();
    assert!(matches!(pipeline.render(), Err(PipelineError::Unsupported(_))));
}
