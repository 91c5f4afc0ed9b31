//! Primary visibility and surface attributes.

#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{Criterion, criterion_group, criterion_main};
use halflight::gbuffer::GBuffer;
use halflight_benches::{HEIGHT, WIDTH, scene};

fn bench(c: &mut Criterion) {
    let (scene, bvh) = scene("atrium").unwrap();
    let mut gbuffer = GBuffer::default();
    let mut group = c.benchmark_group("gbuffer");
    group.sample_size(20);
    group.bench_function("packets", |b| {
        b.iter(|| halflight::cpu::gbuffer::trace(&bvh, &scene, WIDTH, HEIGHT, &mut gbuffer));
    });
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
