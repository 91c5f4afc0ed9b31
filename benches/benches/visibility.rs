//! Shadow rays that share a receiver: packets against single rays. Throughput is in rays.

#![allow(missing_docs, clippy::unwrap_used)]

use criterion::Throughput;
use criterion::{Criterion, criterion_group, criterion_main};
use halflight::bvh::BvhRays;
use halflight::frame::{Frame, Sharing};
use halflight::mask::{MaskBatch, Purpose};
use halflight::pattern::{Pattern, PatternKind};
use halflight::pyramid::Pyramid;
use halflight::stages::Visibility;
use halflight_benches::{atrium, warm};

fn bench(c: &mut Criterion) {
    let (scene, bvh) = atrium().unwrap();
    let pipeline = warm(&scene, &bvh, "full").unwrap();
    let gbuffer = pipeline.gbuffer();
    let (pyramid, sharing) = (Pyramid::default(), Sharing::Receiver);
    let mut group = c.benchmark_group("visibility");
    group.sample_size(10);
    for count in [16, 64, 256] {
        let pattern = Pattern::with_count(PatternKind::Jittered, count).unwrap();
        let frame = Frame { scene: &scene, gbuffer, pyramid: &pyramid, pattern, sharing, index: 0, seed: 0 };
        let mut batch = MaskBatch::default();
        batch.reset(0, pattern, Purpose::Final);
        for pixel in (0..gbuffer.pixels()).step_by(7) {
            if let Some(receiver) = gbuffer.receiver(pixel) {
                batch.push(receiver.origin, receiver.normal, pixel as u32, pixel as u32, None);
            }
        }
        group.throughput(Throughput::Elements((batch.len() * count) as u64));
        let backends =
            [("packets", BvhRays::new(bvh.clone())), ("single rays", BvhRays::single_rays(bvh.clone()))];
        for (name, mut rays) in backends {
            group.bench_function(format!("{name}/{count}"), |b| b.iter(|| rays.masks(&frame, &mut batch)));
        }
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
