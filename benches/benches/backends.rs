//! Visibility backends on tiles of neighbouring receivers, prepared once, on two threads. Throughput is in
//! samples of masks.

#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use halflight::config::{Named, VisibilityConfig};
use halflight::frame::{Frame, Sharing};
use halflight::mask::{MaskBatch, Purpose};
use halflight::pattern::{Pattern, PatternKind};
use halflight::pyramid::Pyramid;
use halflight_benches::{scene, warm};

/// Side of a tile in pixels, and spacing of tiles in tiles.
const TILE: u32 = 8;
const EVERY: u32 = 4;

fn bench(c: &mut Criterion) {
    let threads = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    for name in ["atrium", "nave", "hairball"] {
        let (scene, bvh) = scene(name).unwrap();
        let pipeline = warm(&scene, &bvh, "per-pixel").unwrap();
        let gbuffer = pipeline.gbuffer();
        let mut group = c.benchmark_group(format!("backends/{name}"));
        group.sample_size(10);
        for count in [64, 1024] {
            let pattern = Pattern::with_count(PatternKind::ShiftedRows, count).unwrap();
            let (pyramid, sharing) = (Pyramid::default(), Sharing::Receiver);
            let frame =
                Frame { scene: &scene, gbuffer, pyramid: &pyramid, pattern, sharing, index: 0, seed: 0 };
            let mut batch = MaskBatch::default();
            batch.reset(0, pattern, Purpose::Final);
            for top in (0..gbuffer.height).step_by((TILE * EVERY) as usize) {
                for left in (0..gbuffer.width).step_by((TILE * EVERY) as usize) {
                    for (x, y) in (0..TILE * TILE).map(|at| (left + at % TILE, top + at / TILE)) {
                        let pixel = y * gbuffer.width + x;
                        if let Some(receiver) = gbuffer.receiver(pixel as usize) {
                            batch.push(receiver.origin, receiver.normal, pixel, pixel, None);
                        }
                    }
                }
            }
            group.throughput(Throughput::Elements((batch.len() * pattern.len()) as u64));
            for name in VisibilityConfig::NAMES {
                let mut backend = VisibilityConfig::named(name).unwrap().stage(&bvh).unwrap();
                backend.prepare(&frame);
                group.bench_function(BenchmarkId::new(*name, count), |b| {
                    threads.install(|| b.iter(|| backend.masks(&frame, &mut batch)));
                });
            }
        }
        group.finish();
    }
}

criterion_group!(benches, bench);
criterion_main!(benches);
