//! Discontinuity pyramid.

#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{Criterion, criterion_group, criterion_main};
use halflight::pyramid::{MAX_LEVEL, Pyramid};
use halflight_benches::{scene, warm};

fn bench(c: &mut Criterion) {
    let (scene, bvh) = scene("atrium").unwrap();
    let pipeline = warm(&scene, &bvh, "per-pixel").unwrap();
    let mut pyramid = Pyramid::default();
    let mut group = c.benchmark_group("pyramid");
    group.sample_size(20);
    group.bench_function("levels 1-7", |b| {
        b.iter(|| halflight::cpu::pyramid::build(pipeline.gbuffer(), MAX_LEVEL, &mut pyramid));
    });
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
