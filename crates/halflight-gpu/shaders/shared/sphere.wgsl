// Sphere lights, which every receiver sees as another disk, as in halflight-core/src/light/sphere.rs. The CPU computes the disk in double
// precision, so that samples agree within rounding.

// Outline of a sphere light. Polygons have three corners at least.
const SPHERE: u32 = 2u;

// Distance from the sphere within which a receiver counts as lying on it, relative to the largest coordinate.
const SPHERE_ROUNDING: f32 = 32.0 / 16777216.0;

// Parallelogram around the light that a receiver sees: corner and edges.
struct SeenLight {
    corner: vec3<f32>,
    u: vec3<f32>,
    v: vec3<f32>,
}

fn is_sphere() -> bool {
    return frame.outline.x == SPHERE;
}

// Centre and radius. The first four places hold the corners of the tetrahedron around the sphere.
fn sphere() -> vec4<f32> {
    return frame.outline_corners[4];
}

fn length3(a: vec3<f32>) -> f32 {
    return sqrt(dot3(a, a));
}

// Bound on the rounding of distances between a receiver and the sphere.
fn sphere_slack(origin: vec3<f32>) -> f32 {
    let sizes = max(abs(origin), abs(sphere().xyz));
    return max(max(max(sizes.x, sizes.y), sizes.z), sphere().w) * SPHERE_ROUNDING;
}

// True for receivers inside the light, or as near to it as rounding.
fn surrounded(origin: vec3<f32>) -> bool {
    return is_sphere() && length3(origin - sphere().xyz) <= sphere().w + sphere_slack(origin);
}

// Square around the disk that covers the sphere.
fn sphere_seen(origin: vec3<f32>) -> SeenLight {
    let radius = sphere().w;
    let to = sphere().xyz - origin;
    let far = length3(to);
    let unit = to / far;
    // Images of the X and Z axes under the smallest rotation that takes the Y axis to the direction.
    let level = unit.x * unit.x + unit.z * unit.z;
    let factor = select((1.0 - unit.y) / max(level, 1e-30), 1.0 / (1.0 + unit.y), unit.y >= 0.0);
    let along = vec3(1.0 - unit.x * unit.x * factor, -unit.x, -unit.x * unit.z * factor);
    let across = vec3(-unit.x * unit.z * factor, -unit.z, 1.0 - unit.z * unit.z * factor);
    let rim = radius * sqrt((far - radius) * (far + radius)) / far;
    let centre = sphere().xyz - unit * (radius * radius / far);
    return SeenLight(centre - (along + across) * rim, along * (2.0 * rim), across * (2.0 * rim));
}

// Point just before that where the segment from a receiver to a point of its disk enters the sphere; the receiver itself if nothing is left of
// the segment.
fn before_sphere(origin: vec3<f32>, point: vec3<f32>) -> vec3<f32> {
    let radius = sphere().w;
    let to = sphere().xyz - origin;
    let d = point - origin;
    let far = length3(to);
    let reach = length3(d);
    let along = dot3(to, d) / reach;
    let outside = (far - radius) * (far + radius);
    let enter = outside / (along + sqrt(max(along * along - outside, 0.0)));
    let end = min(enter, reach) - sphere_slack(origin);
    return select(origin, origin + d * (end / reach), end > 0.0);
}

// Number that stands for the part of the sphere above a receiver's horizon, as that of a parallelogram's corners: 4 for all of it, 0 for none.
fn sphere_above(origin: vec3<f32>, normal: vec3<f32>) -> u32 {
    let height = dot3(normal, sphere().xyz - origin);
    if height >= sphere().w {
        return 4u;
    }
    return select(2u, 0u, height <= -sphere().w);
}

// Unit vector from the sphere to a receiver.
fn sphere_facing(origin: vec3<f32>) -> vec3<f32> {
    let away = origin - sphere().xyz;
    let far = length3(away);
    return select(vec3(0.0, 1.0, 0.0), away / far, far > 0.0);
}
