//! Shadow rays that share a receiver or a light sample: packets against single rays, on one thread.
//! Throughput is in rays.

#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use halflight::frame::{Frame, Sharing};
use halflight::mask::{MaskBatch, Purpose};
use halflight::pattern::{Pattern, PatternKind};
use halflight::pyramid::Pyramid;
use halflight::rays::BvhRays;
use halflight::stages::Visibility;
use halflight_benches::{scene, warm};

/// Number of samples of each receiver's pattern, and number of wanted ones.
const ASKED: [(&str, PatternKind, usize, u64); 5] = [
    ("16 of 16", PatternKind::Jittered, 16, u64::MAX),
    ("64 of 64", PatternKind::Jittered, 64, u64::MAX),
    ("256 of 256", PatternKind::Jittered, 256, u64::MAX),
    ("4 of 64", PatternKind::Jittered, 64, 0x0001_8000_0180_0000),
    ("4 of 64 shared", PatternKind::Grid, 64, 0x0001_8000_0180_0000),
];

fn bench(c: &mut Criterion) {
    let thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    for name in ["atrium", "nave", "hairball"] {
        let (scene, bvh) = scene(name).unwrap();
        let pipeline = warm(&scene, &bvh, "per-pixel").unwrap();
        let gbuffer = pipeline.gbuffer();
        let (pyramid, sharing) = (Pyramid::default(), Sharing::Receiver);
        let mut group = c.benchmark_group(format!("visibility/{name}"));
        group.sample_size(10);
        for (asked, kind, count, wanted) in ASKED {
            let pattern = Pattern::with_count(kind, count).unwrap();
            let frame =
                Frame { scene: &scene, gbuffer, pyramid: &pyramid, pattern, sharing, index: 0, seed: 0 };
            let mut batch = MaskBatch::default();
            batch.reset(0, pattern, Purpose::Final);
            for (row, y) in (0..gbuffer.height).step_by(if name == "hairball" { 48 } else { 12 }).enumerate()
            {
                // Runs of neighbours, as in the batches of refiners.
                for x in (0..gbuffer.width).filter(|x| x / 16 % 4 == row as u32 % 4) {
                    let pixel = y * gbuffer.width + x;
                    if let Some(receiver) = gbuffer.receiver(pixel as usize) {
                        batch.push(receiver.origin, receiver.normal, pixel, pixel, Some(&[wanted; 4]));
                    }
                }
            }
            let rays: u32 = batch.queries().iter().map(|query| query.asked).sum();
            group.throughput(Throughput::Elements(u64::from(rays)));
            let backends =
                [("packets", BvhRays::new(bvh.clone())), ("single rays", BvhRays::single_rays(bvh.clone()))];
            for (name, mut rays) in backends {
                group.bench_function(BenchmarkId::new(name, asked), |b| {
                    thread.install(|| b.iter(|| rays.masks(&frame, &mut batch)));
                });
            }
        }
        group.finish();
    }
}

criterion_group!(benches, bench);
criterion_main!(benches);
