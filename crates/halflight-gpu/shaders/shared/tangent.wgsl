// Surface test for upsamplers: decides if two pixels see the same surface
// (halflight-cpu/src/upsample/surface.rs).
//@ needs shared/offset shared/receiver

struct Tangent {
    point: vec3<f32>,
    up: vec3<f32>,
    // Squared distance off a plane up to which values are mixed, square metres.
    allowed: f32,
}

struct Misfit {
    // Squared distance off each other's planes, relative to the allowed one.
    off: f32,
    // Cosine between the normals.
    cosine: f32,
}

fn tangent_at(pixel: u32) -> Tangent {
    let point = position[pixel];
    // Far from the origin single precision is coarser than a pixel.
    let allowed = frame.surface.x * point.w + rounding_at(point.xyz);
    return Tangent(point.xyz, normal_at(pixel), allowed * allowed + 1.17549435e-38);
}

fn misfit(a: Tangent, b: Tangent) -> Misfit {
    let between = a.point - b.point;
    let off_a = dot3(a.up, between);
    let off_b = dot3(b.up, between);
    let off = max(off_a * off_a, off_b * off_b);
    let cosine = dot3(a.up, b.up);
    let allowed = a.allowed + frame.surface.y * max(1.0 - cosine, 0.0) * dot3(between, between);
    return Misfit(off / allowed, cosine);
}

// Agreement of two surfaces: 1 on one surface, 0 on separate ones, in between near the limits.
fn agreement(a: Tangent, b: Tangent) -> f32 {
    let found = misfit(a, b);
    let flat = clamp(2.0 - 2.0 * found.off, 0.0, 1.0);
    return flat * clamp((found.cosine - frame.surface.z) * frame.surface.w, 0.0, 1.0);
}

// Match of two surfaces, never 0: orders surfaces where none agrees.
fn likeness(a: Tangent, b: Tangent) -> f32 {
    let found = misfit(a, b);
    let towards = clamp(0.5 + 0.5 * found.cosine, 0.0, 1.0);
    return max(1.0 / (1.0 + found.off), 1e-6) * max(towards * towards, 1e-3);
}
