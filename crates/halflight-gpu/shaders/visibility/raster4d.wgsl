// 4D rasterization (Wang17 §3.1), as in halflight-cpu/src/raster4d: points are projected through all points
// of the light at once.
//
// In the light's own coordinates a point has a place (u, v) over the light, whose corners are 0 and 1, and a height h above
// its plane. The line through the point q of the light has the slope (u − q) / h, so over all of the light a point has an
// interval of slopes, and with v a rectangle. What hides anything from a receiver has a rectangle that covers the
// receiver's.
//@ needs shared/light

// Cells per side of the finest framebuffer; each coarser one has half as many, down to a single cell.
override FRAMEBUFFER: u32 = 128u;
override LEVELS: u32 = 8u;
// Number of cells of all levels.
override CELLS: u32 = 21845u;
// Number of triangles of the scene that have no alpha mask.
override TRIANGLES: u32 = 0u;

// Number of receivers and of triangles that a workgroup processes.
const GROUP: u32 = 32u;
const RUN: u32 = 512u;

// Layout of `bins`. First the bounds of the slopes, four words per side of the light, the lower ones
// inverted; then the number of tasks. Then, for every cell of all levels, the end of its triangles. For every
// finest cell: the end of its receivers, the number of triangles over it, and its first task. Then, for every
// query and every triangle, the cells that contain it; then all queries and all triangles, cell by cell.
const TASKS: u32 = 8u;
const TRIANGLE_ENDS: u32 = 16u;

fn finest_cells() -> u32 {
    return frame.sides * FRAMEBUFFER * FRAMEBUFFER;
}

fn receiver_ends() -> u32 {
    return TRIANGLE_ENDS + frame.sides * CELLS;
}

fn lengths() -> u32 {
    return receiver_ends() + finest_cells();
}

fn first_tasks() -> u32 {
    return lengths() + finest_cells();
}

fn cells_of_queries() -> u32 {
    return first_tasks() + finest_cells();
}

fn cells_of_triangles() -> u32 {
    return cells_of_queries() + frame.capacity;
}

fn query_order() -> u32 {
    return cells_of_triangles() + frame.sides * TRIANGLES;
}

fn triangle_order() -> u32 {
    return query_order() + frame.capacity;
}

fn level_side(level: u32) -> u32 {
    return (FRAMEBUFFER + (1u << level) - 1u) >> level;
}

// Margin in edges by which a light is extended: more than all rounding of samples.
const MARGIN: f32 = 0.015625;
const UNBOUNDED: f32 = 1e30;

// Point in the light's coordinate system, with bounds on its rounding errors.
struct Local {
    at: vec2<f32>,
    height: f32,
    at_error: vec2<f32>,
    height_error: f32,
}

struct Rectangle {
    low: vec2<f32>,
    high: vec2<f32>,
}

fn local(point: vec3<f32>, side: u32) -> Local {
    let along = from_light(point);
    let dual = light_dual();
    let sign = select(1.0, -1.0, side == 1u);
    // 2⁻²¹ of the products' magnitudes.
    let size = abs(along) * 4.76837158203125e-7;
    return Local(
        vec2(dot3(along, dual.u), dot3(along, dual.v)),
        dot3(along, frame.light_normal) * sign,
        vec2(dot3(size, abs(dual.u)), dot3(size, abs(dual.v))),
        dot3(size, abs(frame.light_normal)),
    );
}

// Slope of the line from a point of the light.
fn slope(p: Local, q: f32) -> vec2<f32> {
    return (p.at - q) / p.height;
}

fn slope_error(p: Local) -> vec2<f32> {
    let reach = abs(p.at) + 1.0 + MARGIN;
    return 1.0625 * (p.at_error + reach * (p.height_error / p.height + 4.76837158203125e-7)) / p.height;
}

// Upper bound on the distance of samples from the light's plane.
fn thickness() -> f32 {
    return light_reach() * 9.5367431640625e-7;
}

// Slopes, in lengths of the light's edges, mapped to -1 … 1.
fn squeezed(x: vec2<f32>) -> vec2<f32> {
    let size = x * light_lengths();
    return size / (1.0 + abs(size));
}

// Side of the light on which a point lies.
fn side_of(point: vec3<f32>) -> u32 {
    return select(0u, 1u, light_side(point) < 0.0);
}

// True if a receiver's rectangle and position bound the triangles that hide the light from it: it is not too
// near the light's plane.
fn is_projected(p: Local) -> bool {
    let reach = max(abs(p.at.x), abs(p.at.y)) + 2.0;
    let aside = thickness() / p.height * reach;
    let error = max(p.at_error.x, p.at_error.y) + p.height_error / p.height * reach;
    return p.height > 0.0 && aside + error < MARGIN * 0.25;
}

// Rectangle of a receiver, rounded inwards.
fn receiver_rectangle(p: Local) -> Rectangle {
    let error = slope_error(p);
    return Rectangle(slope(p, 1.0 + MARGIN) + error, slope(p, -MARGIN) - error);
}

// Finest cell at mapped slopes; positions outside the bounds belong to the border cells.
fn cell_at(place: vec2<f32>, bounds: Rectangle) -> vec2<u32> {
    let size = max(bounds.high - bounds.low, vec2(1e-6));
    let at = (place - bounds.low) / size * f32(FRAMEBUFFER);
    return vec2<u32>(clamp(at, vec2(0.0), vec2(f32(FRAMEBUFFER - 1u))));
}
