//! Whole frames: the per-pixel refiner against each other one, 64 samples, default upsampler and shading.

#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{Criterion, criterion_group, criterion_main};
use halflight::config::{Named, RefinerConfig};
use halflight_benches::{scene, warm};

fn bench(c: &mut Criterion) {
    let (scene, bvh) = scene("atrium").unwrap();
    let mut group = c.benchmark_group("frame");
    group.sample_size(10);
    for &refiner in RefinerConfig::NAMES {
        let mut pipeline = warm(&scene, &bvh, refiner).unwrap();
        group.bench_function(refiner, |b| {
            b.iter(|| pipeline.render().map(|image| image.stats.total_ms).unwrap());
        });
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
