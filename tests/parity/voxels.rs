//! Parity of voxels, and of rays through them.

use halflight::config::{PipelineConfig, RefinerConfig, UpsamplerConfig, VisibilityConfig};
use halflight::frame::{Frame, Sharing};
use halflight::gbuffer::NO_PRIMITIVE;
use halflight::glam::{DVec3, Vec2, Vec3};
use halflight::irradiance::Shading;
use halflight::light::AreaLight;
use halflight::mask::Query;
use halflight::pattern::{Pattern, PatternKind};
use halflight::pyramid::Pyramid;
use halflight::refine::{LatticeConfig, NicholsConfig, SfvtGassConfig};
use halflight::scene::Mesh;
use halflight::stages::Visibility;
use halflight::voxel::{Frustum, Traversal, VoxelConfig, Voxels, turned};
use halflight_gpu::{Inputs, Inside, Surfaces};
use std::sync::Arc;

use halflight_tests::{Stage, blocker_over_floor, quads};

use crate::device::Bench;
use crate::masks::{gpu_masks, halves};
use crate::rays::masked_clearance;
use crate::scenes::{SCENES, Twins, per_pixel};
use crate::whole::nmse2;

/// Rounding error of a point in single precision, in voxels: a few units in the last place at 128, and as
/// much again for the distances that it is computed from, with a margin.
const ROUNDING: f64 = 1e-3;

fn marching(config: VoxelConfig) -> PipelineConfig {
    PipelineConfig { visibility: VisibilityConfig::Voxel(config), ..per_pixel(60, 45, Shading::Ratio) }
}

/// Voxels of the CPU for its last frame.
fn voxels(twins: &Twins, config: VoxelConfig) -> Voxels {
    let frame = Frame {
        scene: &twins.stage.scene,
        gbuffer: twins.cpu.gbuffer(),
        pyramid: &Pyramid::default(),
        // Pattern and key are irrelevant to preparation.
        pattern: Pattern { kind: PatternKind::Grid, columns: 1, rows: 1 },
        sharing: Sharing::Frame,
        index: 0,
        seed: 0,
    };
    let mut voxels = Voxels::new(config).unwrap();
    voxels.prepare(&frame);
    voxels
}

/// Words before the GPU's voxels, and the voxels.
fn gpu_voxels(bench: &Bench, twins: &Twins) -> (Vec<u32>, Vec<u64>) {
    let mut head: Vec<u32> = bench.read(twins.gpu.inside(Inside::Voxels));
    let words = head.split_off(4 + twins.stage.scene.lights.len());
    (head, words.chunks(2).map(|pair| u64::from(pair[0]) | u64::from(pair[1]) << 32).collect())
}

/// Triangles in the grid's homogeneous coordinates.
struct Placed<'a> {
    frustum: &'a Frustum,
    triangles: Vec<[DVec3; 3]>,
}

impl<'a> Placed<'a> {
    fn new(frustum: &'a Frustum, mesh: &Mesh) -> Self {
        let place = |triangle: usize| mesh.corners(triangle).map(|corner| frustum.place(corner));
        Self { frustum, triangles: (0..mesh.triangle_count()).map(place).collect() }
    }

    /// True if a triangle touches a voxel extended beyond its borders by this much, in voxels.
    fn touch(&self, voxel: [usize; 3], beyond: f64) -> bool {
        let [low, high] = [-beyond, 1.0 + beyond].map(|by| voxel.map(|at| at as f64 + by));
        let depth = |slice: f64| f64::from(self.frustum.near) + slice / self.frustum.slices();
        let [near, far] = [depth(low[2]), depth(high[2])];
        let inside = |p: DVec3, side: usize| match side {
            0 | 1 => p[side] - low[side] * p.z,
            2 | 3 => high[side - 2] * p.z - p[side - 2],
            4 => p.z - near,
            _ => far - p.z,
        };
        self.triangles.iter().any(|triangle| {
            let reaches = |side| triangle.iter().any(|&corner| inside(corner, side) >= 0.0);
            (0..6).all(reaches)
                && !(0..6)
                    .fold(triangle.to_vec(), |corners, side| clipped(&corners, |p| inside(p, side)))
                    .is_empty()
        })
    }
}

/// Part of a convex polygon where an affine function is not negative.
fn clipped(corners: &[DVec3], side: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut kept = Vec::new();
    for (at, &to) in corners.iter().enumerate() {
        let from = corners[(at + corners.len() - 1) % corners.len()];
        let (before, after) = (side(from), side(to));
        if (before < 0.0) != (after < 0.0) {
            kept.push(from + (to - from) * (before / (before - after)));
        }
        if after >= 0.0 {
            kept.push(to);
        }
    }
    kept
}

/// Number of differing voxels that are examined.
const LOOKED_AT: usize = 50;

/// Numbers of voxels that one side alone has set, of those among a subset of them that rounding does not
/// explain, and of all that the CPU has set.
fn compare_voxels(bench: &Bench, twins: &Twins, config: VoxelConfig) -> [usize; 3] {
    let cpu = voxels(twins, config);
    let frustum = cpu.frustum().unwrap();
    let placed = Placed::new(frustum, &twins.stage.scene.mesh);
    let (expected, (_, found)) = (cpu.words(), gpu_voxels(bench, twins));
    assert_eq!(found.len(), expected.len());
    let depth = frustum.bits.div_ceil(64);
    let differing: Vec<[usize; 3]> = (0..64 * expected.len())
        .filter(|bit| (expected[bit / 64] ^ found[bit / 64]) >> (bit % 64) & 1 == 1)
        .map(|bit| (bit / 64 / depth, bit / 64 % depth * 64 + bit % 64))
        .map(|(texel, slice)| [texel % frustum.side, texel / frustum.side, slice])
        .collect();
    let explained = |&voxel: &[usize; 3]| placed.touch(voxel, ROUNDING) && !placed.touch(voxel, -ROUNDING);
    // Spread over the whole image.
    let every = differing.len().div_ceil(LOOKED_AT).max(1);
    let strange = differing.iter().step_by(every).filter(|&voxel| !explained(voxel)).count();
    let all = expected.iter().map(|word| word.count_ones() as usize).sum();
    [differing.len(), strange, all]
}

#[test]
fn voxels_are_set_as_on_the_cpu() {
    let Some(bench) = Bench::open() else { return };
    // Sixteen more slices than two words hold, to test partially filled words.
    let config = VoxelConfig { depth_bits: 144, ..VoxelConfig::default() };
    for scene in SCENES {
        let twins = Twins::render(&bench, scene, &marching(config), true);
        let [differ, strange, all] = compare_voxels(&bench, &twins, config);
        // Voxels of the GPU reach SIDE / 2²⁰ beyond their borders, 1.2e-4 of a voxel here: about twice that
        // fraction is touched additionally, for each axis.
        assert!(all > 1000 && differ * 1000 <= all, "{scene}: {differ} of {all}");
        assert_eq!(strange, 0, "{scene}");
    }
    // Floor that is much larger than its visible part, whose voxels end at a slant.
    let mut scene = blocker_over_floor();
    let floor = (Vec3::new(-1e3, 0.0, -1e3), Vec3::Z * 2e3, Vec3::X * 2e3);
    scene.mesh = Arc::new(quads(&[floor, (Vec3::new(-0.5, 1.0, -0.5), Vec3::Z, Vec3::X)]));
    let mut twins = Twins::of(&bench, Stage::new(scene).unwrap(), &marching(config), true);
    let [differ, strange, all] = compare_voxels(&bench, &twins, config);
    assert!(all > 1000 && differ * 100 <= all && strange == 0, "{differ} and {strange} of {all}");
    // Bands of a large triangle with rows missing between them.
    let bands = ["visibility/voxel_fill", "task % bands() * BAND + ", "task % bands() * (BAND + 1u) + "];
    twins.alter(&bench, &marching(config), bands);
    let [differ, strange, _] = compare_voxels(&bench, &twins, config);
    assert!(differ * 100 > all && strange > 0, "{differ} and {strange} of {all}");
}

#[test]
fn depths_that_are_none_hide_nothing() {
    let Some(bench) = Bench::open() else { return };
    let config = marching(VoxelConfig::default());
    let mut twins = Twins::render(&bench, "few toys", &config, true);
    let pixel = twins.cpu.gbuffer().primitive.iter().position(|&triangle| triangle != NO_PRIMITIVE).unwrap();
    let place = 16 * pixel as u64 + 12;
    let off = |twins: &mut Twins, depth: f32| {
        bench.gpu.queue.write_buffer(twins.gpu.position(), place, &depth.to_ne_bytes());
        bench.render(&mut twins.gpu, &Inputs { surfaces: Surfaces::Kept, ..Inputs::default() });
        nmse2(&bench.read::<[f32; 4]>(twins.gpu.image()), twins.cpu.image())
    };
    for depth in [f32::INFINITY, f32::MAX, -1e30, f32::NAN] {
        // Voxels may begin or end elsewhere and be different; shadows stay.
        let off = off(&mut twins, depth);
        assert!(off < 0.05, "{depth}: {off:e}");
    }
    twins.alter(&bench, &config, ["visibility/voxel_range", "depth < INFINITE", "true"]);
    assert!(off(&mut twins, -1e30) > 0.05);
}

#[test]
fn wrong_voxels_are_found() {
    let Some(bench) = Bench::open() else { return };
    let config = VoxelConfig::default();
    // Slices half a slice too far, and a triangle of the blocker that is dropped.
    let slices = [
        "visibility/voxel_fill",
        "(depths - range.x) * density(range)",
        "(depths - range.x) * density(range) + 0.5",
    ];
    let mut twins = Twins::render(&bench, "few toys", &marching(config), true);
    assert_eq!(compare_voxels(&bench, &twins, config)[1], 0);
    twins.alter(&bench, &marching(config), slices);
    assert!(compare_voxels(&bench, &twins, config)[1] > 0);
    let mut twins = Twins::of(&bench, Stage::new(blocker_over_floor()).unwrap(), &marching(config), true);
    assert_eq!(compare_voxels(&bench, &twins, config)[1], 0);
    let mut lossy = blocker_over_floor();
    Arc::make_mut(&mut lossy.mesh).triangles.pop();
    Arc::make_mut(&mut lossy.mesh).material_ids.pop();
    twins.gpu = bench.renderer(&lossy, &marching(config)).unwrap();
    bench.keep(&twins.gpu, twins.cpu.gbuffer());
    bench.render(&mut twins.gpu, &Inputs { surfaces: Surfaces::Kept, ..Inputs::default() });
    assert!(compare_voxels(&bench, &twins, config)[1] > 0);
}

#[test]
fn refiners_ask_voxels_as_on_the_cpu() {
    let Some(bench) = Bench::open() else { return };
    let refiners = [
        RefinerConfig::PerPixel,
        RefinerConfig::Nichols(NicholsConfig::default()),
        RefinerConfig::SfvtGass(SfvtGassConfig::default()),
        RefinerConfig::Lattice(LatticeConfig::default()),
    ];
    for refiner in refiners {
        // In smaller images a single voxel is more than the bound below.
        let usual = PipelineConfig { width: 80, height: 60, ..marching(VoxelConfig::default()) };
        let upsampler = match refiner {
            RefinerConfig::Lattice(_) => UpsamplerConfig::Lattice(Default::default()),
            _ => usual.upsampler,
        };
        let config = PipelineConfig { refiner, upsampler, ..usual };
        let twins = Twins::render(&bench, "toys", &config, true);
        let image: Vec<[f32; 4]> = bench.read(twins.gpu.image());
        let off = nmse2(&image, twins.cpu.image());
        // Voxels and rays that rounding decides differently are single ones; other light samples make 1e-4
        // and more.
        assert!(off < 1e-6, "{refiner:?}: {off:e}");
        let other = PipelineConfig { seed: 1, ..config };
        let image: Vec<[f32; 4]> = bench.read(Twins::render(&bench, "toys", &other, true).gpu.image());
        let off = nmse2(&image, twins.cpu.image());
        assert!(off > 1e-5, "{refiner:?}: {off:e}");
    }
}

/// Double-precision test of a ray.
struct March<'a> {
    frustum: &'a Frustum,
    config: VoxelConfig,
    light: AreaLight,
    /// Distance before the light's plane at which rays end, metres.
    clearance: f32,
    cpu: &'a [u64],
    gpu: &'a [u64],
}

impl March<'_> {
    /// True if rounding may decide a ray: one of its samples is within the rounding error of a border of its
    /// voxel, or in a voxel that only one side has set.
    fn is_close(&self, query: &Query, sample: Vec2) -> bool {
        let Traversal::Steps { count } = self.config.traversal else { panic!("samples only") };
        let Frustum { near, far, side, bits, .. } = *self.frustum;
        let push = self.config.bias * self.frustum.width_along(query.origin, query.normal);
        let from = self.frustum.place(query.origin + query.normal * push);
        let height = self.light.normal().dot(query.origin - self.light.frame().origin);
        let lift = self.clearance.min(height.abs() * 0.5).copysign(height);
        let to = turned(self.frustum, &self.light).point(sample).as_dvec3()
            + self.frustum.turn((self.light.normal() * lift).as_dvec3());
        (0..count).any(|step| {
            let p = from + (to - from) * ((f64::from(step) + 0.5) / f64::from(count));
            let slice = (p.z - f64::from(near)) * self.frustum.slices();
            let at = DVec3::new(p.x / p.z, p.y / p.z, slice);
            let on_border = at.to_array().iter().any(|x| (x - x.round()).abs() < ROUNDING);
            let size = [side as f64, side as f64, bits as f64];
            let inside =
                p.z > 0.0 && f64::from(far) > p.z && (0..3).all(|axis| (0.0..size[axis]).contains(&at[axis]));
            on_border
                || inside && {
                    let word =
                        (at.y as usize * side + at.x as usize) * bits.div_ceil(64) + at.z as usize / 64;
                    (self.cpu[word] ^ self.gpu[word]) >> (at.z as usize % 64) & 1 == 1
                }
        })
    }
}

/// Numbers of rays with different visibility, of those that rounding does not explain, and of all.
pub(crate) fn compare(bench: &Bench, twins: &Twins, config: VoxelConfig) -> [usize; 3] {
    let batch = twins.cpu.fragments().batch(0);
    let words = batch.pattern().len().div_ceil(32);
    let found = gpu_masks(bench, &twins.gpu, words);
    assert_eq!(found.len(), batch.len());
    let expected = voxels(twins, config);
    let cpu = expected.words();
    let (head, gpu) = gpu_voxels(bench, twins);
    let march = March {
        frustum: expected.frustum().unwrap(),
        config,
        light: twins.stage.scene.lights[0],
        clearance: f32::from_bits(head[4]),
        cpu: &cpu,
        gpu: &gpu,
    };
    let [mut flips, mut strange, mut rays] = [0; 3];
    for (index, query) in batch.queries().iter().enumerate() {
        let (_, wanted, visible) = &found[&query.pixel];
        assert_eq!(wanted[..], halves(batch.wanted(index))[..words]);
        let expected = halves(batch.visible(index));
        for sample in 0..batch.pattern().len() {
            let bit = |mask: &[u32]| mask[sample / 32] >> (sample % 32) & 1;
            rays += bit(wanted) as usize;
            if bit(visible) != bit(&expected) {
                flips += 1;
                if matches!(config.traversal, Traversal::Steps { .. }) {
                    let place = batch.pattern().position(sample, query.key);
                    // Masked triangles are not marched through: allowed as in `masks`.
                    let slack = f64::from(twins.stage.bvh.diagonal()) * 16.0 / f64::from(1 << 24);
                    let close = march.is_close(query, place)
                        || masked_clearance(&twins.stage.scene.mesh, query.origin, march.light.point(place))
                            < slack;
                    strange += usize::from(!close);
                }
            }
        }
    }
    [flips, strange, rays]
}

#[test]
fn rays_march_as_on_the_cpu() {
    let Some(bench) = Bench::open() else { return };
    let usual = VoxelConfig::default();
    let thick = VoxelConfig { thickness: 2, bias: 0.5, resolution: 100, ..usual };
    let every = VoxelConfig { traversal: Traversal::Dda, ..usual };
    for (scene, config) in
        SCENES.into_iter().map(|scene| (scene, usual)).chain([("few toys", thick), ("atrium", every)])
    {
        let twins = Twins::render(&bench, scene, &marching(config), true);
        let [flips, strange, rays] = compare(&bench, &twins, config);
        // A ray has 16 samples with three borders each; a few in 10⁴ are within the rounding error of one,
        // and few of these change the visibility. Exact traversal passes many more borders.
        assert!(rays > 50_000 && flips * 10_000 <= rays, "{scene}: {flips} of {rays}");
        assert_eq!(strange, 0, "{scene}");
    }
}

#[test]
fn wrong_constants_are_found() {
    let Some(bench) = Bench::open() else { return };
    let config = VoxelConfig::default();
    let mut twins = Twins::render(&bench, "few toys", &marching(config), true);
    for wrong in [
        VoxelConfig { bias: 1.1, ..config },
        VoxelConfig { thickness: 1, ..config },
        VoxelConfig { traversal: Traversal::Steps { count: 17 }, ..config },
    ] {
        twins.gpu = bench.renderer(&twins.stage.scene, &marching(wrong)).unwrap();
        bench.keep(&twins.gpu, twins.cpu.gbuffer());
        bench.render(&mut twins.gpu, &Inputs { surfaces: Surfaces::Kept, ..Inputs::default() });
        let [flips, strange, rays] = compare(&bench, &twins, config);
        assert!(flips * 1000 > rays && strange > 0, "{wrong:?}: {flips} and {strange} of {rays}");
    }
    // Exact traversal that takes the farther border first.
    let every = VoxelConfig { traversal: Traversal::Dda, ..config };
    let mut twins = Twins::render(&bench, "atrium", &marching(every), true);
    let farther = ["visibility/voxel", "next.x <= next.y", "next.x > next.y"];
    twins.alter(&bench, &marching(every), farther);
    let [flips, _, rays] = compare(&bench, &twins, every);
    assert!(flips * 1000 > rays, "{flips} of {rays}");
}
