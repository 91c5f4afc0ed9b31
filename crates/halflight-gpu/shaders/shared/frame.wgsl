// Uniforms that all stages share. The twin of this struct is `Frame` in frame.rs.

// Index that refers to nothing.
const NONE: u32 = 0xffffffffu;

struct Pattern {
    kind: u32,
    columns: u32,
    rows: u32,
    // Number of samples.
    count: u32,
    // Words of 32 bits in a mask.
    words: u32,
    // Invocations per query: a power of two up to 64, then a multiple of 64.
    stride: u32,
    // Reciprocals of columns and rows, computed on the CPU so that all positions have identical bits.
    scale: vec2<f32>,
}

struct Frame {
    eye: vec3<f32>,
    width: u32,
    // Direction through the top left corner of the image, of unit length along the view direction.
    corner: vec3<f32>,
    height: u32,
    // Offsets of one pixel to the right, and one down.
    right: vec3<f32>,
    level: u32,
    down: vec3<f32>,
    scene_size: f32,
    light_corner: vec3<f32>,
    light_area: f32,
    light_u: vec3<f32>,
    two_sided: u32,
    light_v: vec3<f32>,
    // Index of the light.
    light: u32,
    // Cross product of the light's edges, and the unit vector of its direction.
    light_cross: vec3<f32>,
    key: u32,
    light_normal: vec3<f32>,
    sharing: u32,
    radiance: vec3<f32>,
    // Capacity in queries.
    capacity: u32,
    pattern: Pattern,
    // Thresholds at which geometry alone splits a cell.
    depth_break: f32,
    curvature_break: f32,
    // Number of samples that must change in a neighbourhood to split its centre.
    enough: f32,
    coarsest: u32,
    // Number of queries per cell.
    slots: u32,
    // Most differing bits between quadrants, and between neighbouring ones before they are split two levels
    // down.
    split_above: u32,
    gradient_above: u32,
    // Finest level that a depth discontinuity splits.
    depth_finest: u32,
    // Limits of surfaces within which values are mixed: footprint of a pixel at depth 1, factor of the
    // normal's turn, cosine of the largest turn, and the reciprocal of its distance to the cosine of the
    // largest freely mixed turn.
    surface: vec4<f32>,
    // Limits of the tangent-plane test: sine of an elevation, and footprint of a pixel at depth 1
    // (halflight-cpu/src/tangent_plane.rs).
    crease_sine: f32,
    pixel_footprint: f32,
    // Interpolation tolerance: difference of the visible fraction.
    error: f32,
    // Coarsest level of cells that are kept across depth discontinuities.
    step_level: u32,
    // Number of lights, and of sides that they shine to: 2 where any of them is two-sided.
    lights: u32,
    sides: u32,
    // Largest absolute coordinate of the scene.
    largest: f32,
    // Place of the shading normals behind the geometric ones, in pixels; 0 where they are the same.
    shading: u32,
    // The first cell of each level in buffers that hold all levels.
    levels: array<vec4<u32>, 2>,
    // Outline of the light: 0 for the whole parallelogram, 1 for the ellipse that touches its sides, 2 for a sphere, otherwise the number of corners of a polygon.
    outline: vec4<u32>,
    // Corners of a polygon, from the parallelogram's first corner; of a sphere see shared/sphere.wgsl.
    outline_corners: array<vec4<f32>, 12>,
    // Sides of a polygon: a + b · u + c · v is not negative inside, for a place (u, v).
    outline_sides: array<vec4<f32>, 12>,
    // Mean radiance of the light: that of its texture, if it has one.
    mean_radiance: vec4<f32>,
    // Of a textured light, in `emitted`: index of its first cell, plus one; index of its first stratum, or of that of patterns with the fewest
    // columns where z is 1, since the device chooses the pattern; and index of its first texel, plus one, where texels are known.
    texture: vec4<u32>,
    // Width and height of the texture, and 1 where its rows run along the second edge of the light.
    texture_size: vec4<u32>,
}

@group(0) @binding(0) var<uniform> frame: Frame;

fn level_first(level: u32) -> u32 {
    return frame.levels[level >> 2u][level & 3u];
}

// Number of cells of a level, across and down.
fn level_size(level: u32) -> vec2<u32> {
    let most = (1u << level) - 1u;
    return (vec2(frame.width, frame.height) + most) >> vec2(level);
}

// Index of a cell in buffers that hold all levels.
fn cell_index(level: u32, cell: vec2<u32>) -> u32 {
    return level_first(level) + cell.y * level_size(level).x + cell.x;
}

// Position of an invocation in a dispatch of one or two dimensions, in workgroups of 64.
struct Lane {
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) index: u32,
}

// Position of an invocation in a dispatch of tiles of 8 × 8, one workgroup each.
struct Tile {
    @builtin(global_invocation_id) at: vec3<u32>,
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
}

// Linear index of the workgroup.
fn group_of(here: Lane) -> u32 {
    return here.workgroup.y * here.workgroups.x + here.workgroup.x;
}

// Linear index of the invocation.
fn invocation(here: Lane) -> u32 {
    return group_of(here) * 64u + here.index;
}

// Dot product in a fixed order of operations.
fn dot3(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// Luminance of linear RGB (Rec. 709).
fn luminance(rgb: vec3<f32>) -> f32 {
    return dot3(rgb, vec3(0.2126, 0.7152, 0.0722));
}

fn cross3(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

// Direction through the middle of the image: unit length along the view direction, beside it where the view is off-centre.
fn middle_direction() -> vec3<f32> {
    return frame.corner + frame.right * (f32(frame.width) * 0.5) + frame.down * (f32(frame.height) * 0.5);
}

// Place of the view direction in the image: pixels right of the middle, and below it.
fn off_centre() -> vec2<f32> {
    let middle = middle_direction();
    return -vec2(
        dot3(middle, frame.right) / dot3(frame.right, frame.right),
        dot3(middle, frame.down) / dot3(frame.down, frame.down),
    );
}

// Unit view direction.
fn forward() -> vec3<f32> {
    let place = off_centre();
    return middle_direction() + frame.right * place.x + frame.down * place.y;
}
