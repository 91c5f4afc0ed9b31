//! BVH over triangles that have moved: rebuilt or refitted.

#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{Criterion, criterion_group, criterion_main};
use halflight::bvh::Bvh;
use halflight::scene::Mesh;
use halflight_benches::scene;

fn bench(c: &mut Criterion) {
    let mut group = c.benchmark_group("refit");
    group.sample_size(10);
    for name in ["atrium", "tree"] {
        let (scene, bvh) = scene(name).unwrap();
        let mut mesh = Mesh::clone(&scene.mesh);
        mesh.positions.iter_mut().for_each(|p| p.x += 0.005 * p.y * p.y);
        let mut moved = Bvh::clone(&bvh);
        group.bench_function(format!("{name} build"), |b| b.iter(|| Bvh::build(&mesh).unwrap()));
        group.bench_function(format!("{name} refit"), |b| b.iter(|| moved.refit(&mesh).unwrap()));
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
