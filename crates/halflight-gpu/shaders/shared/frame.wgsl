// What every stage knows: the one uniform. Its twin is `Frame` in frame.rs.

// A number that marks nothing.
const NONE: u32 = 0xffffffffu;

struct Pattern {
    kind: u32,
    columns: u32,
    rows: u32,
    // Samples.
    count: u32,
    // Words of 32 bits in a mask.
    words: u32,
    // Invocations that a query takes: a power of two up to 64, then a multiple of 64.
    stride: u32,
    // One over columns and rows, divided on the CPU so that all positions have the same bits.
    scale: vec2<f32>,
}

struct Frame {
    eye: vec3<f32>,
    width: u32,
    // Direction through the top left corner of the image, one unit along the view direction.
    corner: vec3<f32>,
    height: u32,
    // One pixel to the right, and one down.
    right: vec3<f32>,
    level: u32,
    down: vec3<f32>,
    scene_size: f32,
    light_corner: vec3<f32>,
    light_area: f32,
    light_u: vec3<f32>,
    two_sided: u32,
    light_v: vec3<f32>,
    // Number of the light.
    light: u32,
    // Product of the light's edges, and the same as a unit vector.
    light_cross: vec3<f32>,
    key: u32,
    light_normal: vec3<f32>,
    sharing: u32,
    radiance: vec3<f32>,
    // Room for queries.
    capacity: u32,
    pattern: Pattern,
    // When geometry alone splits a cell.
    depth_break: f32,
    curvature_break: f32,
    // Samples that must change in a neighbourhood to split its middle.
    enough: f32,
    coarsest: u32,
    // Queries of a cell.
    slots: u32,
    // Bits that may differ between quadrants, and between neighbouring ones before they are split twice.
    split_above: u32,
    gradient_above: u32,
    // Finest level that a depth break splits.
    depth_finest: u32,
    // Where values are no longer mixed: footprint of a pixel at depth 1, what a turn of the normal adds, the cosine of the
    // largest turn, and one over the distance of cosines to the largest that is mixed freely.
    surface: vec4<f32>,
    // Limits of the tangent-plane test: sine of an elevation, and footprint of a pixel at depth 1 (halflight-cpu/src/tangent_plane.rs).
    crease_sine: f32,
    pixel_footprint: f32,
    // Difference of the visible fraction that is interpolated over.
    error: f32,
    // Coarsest level at which steps are interpolated along.
    step_level: u32,
    // Number of lights, and of sides that they shine to: 2 where any of them is two-sided.
    lights: u32,
    sides: u32,
    // Largest absolute coordinate of the scene.
    largest: f32,
    // The first cell of each level in buffers that hold all levels.
    levels: array<vec4<u32>, 2>,
}

@group(0) @binding(0) var<uniform> frame: Frame;

fn level_first(level: u32) -> u32 {
    return frame.levels[level >> 2u][level & 3u];
}

// Cells of a level, across and down.
fn level_size(level: u32) -> vec2<u32> {
    let most = (1u << level) - 1u;
    return (vec2(frame.width, frame.height) + most) >> vec2(level);
}

// Index of a cell in buffers that hold all levels.
fn cell_index(level: u32, cell: vec2<u32>) -> u32 {
    return level_first(level) + cell.y * level_size(level).x + cell.x;
}

// Where an invocation is in a dispatch of one or two dimensions, in workgroups of 64.
struct Lane {
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) index: u32,
}

// Where an invocation is in a dispatch of tiles of 8 × 8, a workgroup each.
struct Tile {
    @builtin(global_invocation_id) at: vec3<u32>,
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
}

// The number of its workgroup.
fn group_of(here: Lane) -> u32 {
    return here.workgroup.y * here.workgroups.x + here.workgroup.x;
}

// Its own number.
fn invocation(here: Lane) -> u32 {
    return group_of(here) * 64u + here.index;
}

// Written out, so that no compiler chooses an order.
fn dot3(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

fn cross3(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
