//! Five upsamplers on identical fragments.

#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{Criterion, criterion_group, criterion_main};
use halflight::config::{Named as _, RefinerConfig, UpsamplerConfig};
use halflight::frame::{Frame, Sharing};
use halflight::irradiance::{Shading, evaluate};
use halflight::pattern::{Pattern, PatternKind};
use halflight::pyramid::Pyramid;
use halflight::values::Values;
use halflight_benches::{scene, warm};

fn bench(c: &mut Criterion) {
    let (scene, bvh) = scene("atrium").unwrap();
    let pipeline = warm(&scene, &bvh, "sfvt-gass").unwrap();
    let (gbuffer, pyramid) = (pipeline.gbuffer(), Pyramid::default());
    let pattern = Pattern::with_count(PatternKind::Jittered, 64).unwrap();
    let sharing = Sharing::Fragment;
    let frame = Frame { scene: &scene, gbuffer, pyramid: &pyramid, pattern, sharing, index: 0, seed: 0 };
    let mut values = Values::default();
    evaluate(
        &frame,
        pipeline.fragments(),
        Shading::Ratio,
        &halflight::stages::RefineOutput::default(),
        &mut values,
    );
    let mut out = vec![0.0; gbuffer.pixels()];
    let mut group = c.benchmark_group("upsample");
    group.sample_size(20);
    for upsampler in UpsamplerConfig::all() {
        let mut stage = upsampler.stage(&RefinerConfig::default());
        group.bench_function(upsampler.name(), |b| {
            b.iter(|| stage.upsample(&frame, pipeline.fragments(), values.channel(0), &mut out));
        });
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
