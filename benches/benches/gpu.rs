//! Whole frames on the first GPU found: the per-pixel refiner with every backend, and each refiner with rays,
//! 64 samples. The benchmark waits for every frame. `cargo bench -p halflight-benches --features gpu --bench
//! gpu`

#![allow(missing_docs, clippy::unwrap_used)]

use std::time::Duration;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use halflight::config::{Named, PipelineConfig, RefinerConfig, UpsamplerConfig, VisibilityConfig};
use halflight::frame::LightSampling;
use halflight::gpu::{Gpu, Inputs, Renderer};
use halflight::pattern::PatternKind;
use halflight_benches::{HEIGHT, WIDTH, scene};

fn bench(c: &mut Criterion) {
    let gpu = Gpu::find().unwrap();
    let (scene, _) = scene("atrium").unwrap();
    let per_pixel = VisibilityConfig::NAMES.iter().map(|&visibility| ("per-pixel", visibility));
    let refined = RefinerConfig::NAMES.iter().filter(|&&name| name != "per-pixel").map(|&name| (name, "bvh"));
    let mut group = c.benchmark_group(format!("gpu/{}", gpu.adapter.get_info().name));
    group.sample_size(10).warm_up_time(Duration::from_millis(1));
    for (refiner, visibility) in per_pixel.chain(refined) {
        let config = PipelineConfig {
            width: WIDTH,
            height: HEIGHT,
            refiner: RefinerConfig::named(refiner).unwrap(),
            visibility: VisibilityConfig::named(visibility).unwrap(),
            upsampler: if refiner == "lattice" {
                UpsamplerConfig::Lattice(Default::default())
            } else {
                UpsamplerConfig::RbfRobust(Default::default())
            },
            // Supported by all backends.
            sampling: LightSampling { kind: PatternKind::ShiftedRows, ..LightSampling::default() },
            ..PipelineConfig::default()
        };
        let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &scene, &config).unwrap();
        group.bench_function(BenchmarkId::new(refiner, visibility), |b| {
            b.iter(|| gpu.render(&mut renderer, &Inputs::default()).unwrap());
        });
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
