// Light samples and what they add, as in halflight-cpu/src/samples.rs.
//@ needs shared/hash shared/sphere

const GRID: u32 = 0u;
const SHIFTED_ROWS: u32 = 1u;

// Outlines of lights that are no polygons.
const PARALLELOGRAM: u32 = 0u;
const ELLIPSE: u32 = 1u;

fn unit_pair(bits: u32) -> vec2<f32> {
    return (vec2(f32(bits >> 16u), f32(bits & 0xffffu)) + 0.5) * (1.0 / 65536.0);
}

// Place of a sample in the unit square.
fn sample_place(index: u32, key: u32) -> vec2<f32> {
    let column = index % frame.pattern.columns;
    let row = index / frame.pattern.columns;
    var inside = vec2(0.5);
    if frame.pattern.kind == SHIFTED_ROWS {
        inside = unit_pair(sample_bits(key, row));
    } else if frame.pattern.kind != GRID {
        inside = unit_pair(sample_bits(key, index));
    }
    return (vec2(f32(column), f32(row)) + inside) * frame.pattern.scale;
}

fn sample_point(index: u32, key: u32) -> vec3<f32> {
    return light_point(sample_place(index, key));
}

// The light that a receiver sees: the same for all, but for spheres.
fn seen_light(origin: vec3<f32>) -> SeenLight {
    if is_sphere() {
        return sphere_seen(origin);
    }
    return SeenLight(frame.light_corner, frame.light_u, frame.light_v);
}

// Point at a place in the unit square.
fn seen_point(light: SeenLight, place: vec2<f32>) -> vec3<f32> {
    return light.corner + light.u * place.x + light.v * place.y;
}

// The shape of the light: no other module reads its corner and edges.

// Point of the light at a place in the unit square.
fn light_point(place: vec2<f32>) -> vec3<f32> {
    return frame.light_corner + frame.light_u * place.x + frame.light_v * place.y;
}

// True if a place in the unit square emits (halflight-core/src/light/extent.rs).
fn light_contains(place: vec2<f32>) -> bool {
    if frame.outline.x == ELLIPSE || is_sphere() {
        let at = place * 2.0 - 1.0;
        return at.x * at.x + at.y * at.y <= 1.0;
    }
    for (var index = 0u; index < frame.outline.x; index++) {
        let side = frame.outline_sides[index];
        if side.x + side.y * place.x + side.z * place.y < 0.0 {
            return false;
        }
    }
    return true;
}

// Cross product of the edges of a flat light, on the side of a vector.
fn light_cross_towards(towards: vec3<f32>) -> vec3<f32> {
    return select(frame.light_cross, -frame.light_cross, dot3(towards, frame.light_normal) < 0.0);
}

// Corners, in order around the light, or of a tetrahedron around a sphere.
fn light_corners() -> array<vec3<f32>, 4> {
    if is_sphere() {
        return array(
            frame.outline_corners[0].xyz,
            frame.outline_corners[1].xyz,
            frame.outline_corners[2].xyz,
            frame.outline_corners[3].xyz,
        );
    }
    return corners_from(frame.light_corner);
}

// Corners as seen from a point. Differences first: the corners of a small light far away round to one point.
fn light_corners_seen(origin: vec3<f32>) -> array<vec3<f32>, 4> {
    return corners_from(frame.light_corner - origin);
}

fn corners_from(a: vec3<f32>) -> array<vec3<f32>, 4> {
    return array(a, a + frame.light_u, a + frame.light_u + frame.light_v, a + frame.light_v);
}

// A point as seen from the light's first corner.
fn from_light(point: vec3<f32>) -> vec3<f32> {
    return point - frame.light_corner;
}

struct Bounds {
    low: vec3<f32>,
    high: vec3<f32>,
}

// Box around the light.
fn light_bounds() -> Bounds {
    var corners = light_corners();
    return Bounds(
        min(min(corners[0], corners[1]), min(corners[2], corners[3])),
        max(max(corners[0], corners[1]), max(corners[2], corners[3])),
    );
}

// Least and greatest height of the light above a plane through `point`.
fn light_heights(up: vec3<f32>, point: vec3<f32>) -> vec2<f32> {
    let corner = dot3(up, frame.light_corner - point);
    let u = dot3(up, frame.light_u);
    let v = dot3(up, frame.light_v);
    return vec2(corner + min(u, 0.0) + min(v, 0.0), corner + max(u, 0.0) + max(v, 0.0));
}

// No coordinate of the light is larger.
fn light_reach() -> f32 {
    let sizes = abs(frame.light_corner) + abs(frame.light_u) + abs(frame.light_v);
    return max(max(sizes.x, sizes.y), sizes.z);
}

// Lengths of both edges.
fn light_lengths() -> vec2<f32> {
    return vec2(sqrt(dot3(frame.light_u, frame.light_u)), sqrt(dot3(frame.light_v, frame.light_v)));
}

// Square of the shorter edge.
fn light_shorter_squared() -> f32 {
    return min(dot3(frame.light_u, frame.light_u), dot3(frame.light_v, frame.light_v));
}

// Vectors whose products with a point as seen from the light's first corner are the point's place over the light.
struct Dual {
    u: vec3<f32>,
    v: vec3<f32>,
}

fn light_dual() -> Dual {
    let across_u = cross3(frame.light_v, frame.light_normal);
    let across_v = cross3(frame.light_normal, frame.light_u);
    return Dual(across_u / dot3(across_u, frame.light_u), across_v / dot3(across_v, frame.light_v));
}

// Distance to about the nearest point of the light: exact for rectangles.
fn light_distance(origin: vec3<f32>) -> f32 {
    let place = from_light(origin);
    let u = clamp(dot3(place, frame.light_u) / dot3(frame.light_u, frame.light_u), 0.0, 1.0);
    let v = clamp(dot3(place, frame.light_v) / dot3(frame.light_v, frame.light_v), 0.0, 1.0);
    let off = place - frame.light_u * u - frame.light_v * v;
    return sqrt(dot3(off, off));
}

// Positive on the side that the light's normal points to.
fn light_side(point: vec3<f32>) -> f32 {
    return dot3(frame.light_cross, from_light(point));
}

// The light's unit normal on the side of a point; zero where no light leaves towards it.
fn facing(origin: vec3<f32>) -> vec3<f32> {
    if is_sphere() {
        return sphere_facing(origin);
    }
    let between = from_light(origin);
    let side = light_side(origin);
    if side == 0.0 || (side < 0.0 && frame.two_sided == 0u) {
        return vec3(0.0);
    }
    return select(frame.light_normal, -frame.light_normal, dot3(frame.light_normal, between) < 0.0);
}

// Geometry term of a sample at `d` from the receiver, 0 below either horizon.
fn geometry_term(d: vec3<f32>, normal: vec3<f32>, towards: vec3<f32>) -> f32 {
    let receiver = max(dot3(d, normal), 0.0);
    let emitter = max(dot3(d, -towards), 0.0);
    let squared = dot3(d, d);
    // 0/0 where the receiver lies on the sample itself.
    if squared <= 0.0 {
        return 0.0;
    }
    return receiver * emitter / (squared * squared);
}

// How many of the light's corners are above a receiver's horizon.
fn corners_above(origin: vec3<f32>, normal: vec3<f32>) -> u32 {
    if is_sphere() {
        return sphere_above(origin, normal);
    }
    var corners = light_corners();
    return u32(dot3(normal, corners[0] - origin) > 0.0) + u32(dot3(normal, corners[1] - origin) > 0.0)
        + u32(dot3(normal, corners[2] - origin) > 0.0) + u32(dot3(normal, corners[3] - origin) > 0.0);
}
