//! Sample values from masks, and the analytic unshadowed irradiance at every pixel.

#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{Criterion, criterion_group, criterion_main};
use halflight::frame::{Frame, Sharing};
use halflight::glam::Vec3;
use halflight::irradiance::Shading;
use halflight::pattern::{Pattern, PatternKind};
use halflight::pyramid::Pyramid;
use halflight::unshadowed::unshadowed_many;
use halflight::values::Values;
use halflight_benches::{scene, warm};

fn bench(c: &mut Criterion) {
    let (scene, bvh) = scene("atrium").unwrap();
    let mut group = c.benchmark_group("irradiance");
    group.sample_size(20);
    for refiner in ["per-pixel", "sfvt-gass"] {
        let pipeline = warm(&scene, &bvh, refiner).unwrap();
        let (gbuffer, pyramid) = (pipeline.gbuffer(), Pyramid::default());
        let pattern = Pattern::with_count(PatternKind::Jittered, 64).unwrap();
        let sharing = Sharing::Receiver;
        let frame = Frame { scene: &scene, gbuffer, pyramid: &pyramid, pattern, sharing, index: 0, seed: 0 };
        let mut values = Values::default();
        group.bench_function(format!("samples/{refiner}"), |b| {
            b.iter(|| {
                halflight::irradiance::evaluate(
                    &frame,
                    pipeline.fragments(),
                    Shading::Ratio,
                    &halflight::stages::RefineOutput::default(),
                    &mut values,
                );
            });
        });
    }
    let pipeline = warm(&scene, &bvh, "per-pixel").unwrap();
    let gbuffer = pipeline.gbuffer();
    let receivers = (0..gbuffer.pixels()).filter_map(|pixel| gbuffer.receiver(pixel));
    let (origins, normals): (Vec<Vec3>, Vec<Vec3>) = receivers.map(|r| (r.origin, r.normal)).unzip();
    let mut out = vec![0.0; origins.len()];
    group.bench_function("unshadowed, one thread", |b| {
        b.iter(|| unshadowed_many(&scene.lights[0], &origins, &normals, &mut out));
    });
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
