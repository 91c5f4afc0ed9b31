// Tangent-plane test of two surface points (halflight-cpu/src/tangent_plane.rs).
//@ needs shared/offset shared/receiver

struct Elevations {
    // Heights above each other's tangent planes, metres.
    above_a: f32,
    above_b: f32,
    // What parts them.
    limit: f32,
    // Footprint of a pixel.
    step: f32,
}

// Of two receivers that lie so many columns or rows apart.
fn rises_between(a: u32, b: u32, apart: u32) -> Elevations {
    let pa = position[a];
    let pb = position[b];
    let between = pb.xyz - pa.xyz;
    let step = frame.pixel_footprint * min(pa.w, pb.w) * f32(apart);
    // Far from the origin single precision is coarser than a pixel.
    let rounding = rounding_at(pa.xyz);
    let limit = min(frame.crease_sine * sqrt(dot3(between, between)), step) + rounding;
    return Elevations(dot3(normal_at(a), between), -dot3(normal_at(b), between), limit, step + rounding);
}

// Whether something parts two pixels.
fn is_parted(a: u32, b: u32, apart: u32) -> bool {
    if triangle_at(a) == triangle_at(b) {
        return false;
    }
    if !is_receiver(a) || !is_receiver(b) {
        return true;
    }
    let rises = rises_between(a, b, apart);
    return rises.above_a > rises.limit || rises.above_b > rises.limit;
}

// Whether two pixels lie on one plane or nearly so, seen from both.
fn is_level(a: u32, b: u32, apart: u32) -> bool {
    if triangle_at(a) == triangle_at(b) {
        return true;
    }
    if !is_receiver(a) || !is_receiver(b) {
        return false;
    }
    let rises = rises_between(a, b, apart);
    return abs(rises.above_a) <= rises.limit && abs(rises.above_b) <= rises.limit;
}
