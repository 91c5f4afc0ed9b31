// Tangent-plane test of two surface points (halflight-cpu/src/tangent_plane.rs).
//@ needs shared/offset shared/receiver

struct Elevations {
    // Heights above each other's tangent planes, metres.
    above_a: f32,
    above_b: f32,
    // Height above which there is a surface discontinuity.
    limit: f32,
    // Footprint of a pixel.
    step: f32,
}

// Elevations of two receivers that are `apart` columns or rows from each other.
fn elevations_between(a: u32, b: u32, apart: u32) -> Elevations {
    let pa = position[a];
    let pb = position[b];
    let between = pb.xyz - pa.xyz;
    let step = frame.pixel_footprint * min(pa.w, pb.w) * f32(apart);
    // Far from the origin single precision is coarser than a pixel.
    let rounding = rounding_at(pa.xyz);
    let limit = min(frame.crease_sine * sqrt(dot3(between, between)), step) + rounding;
    return Elevations(dot3(normal_at(a), between), -dot3(normal_at(b), between), limit, step + rounding);
}

// True if there is a surface discontinuity between two pixels.
fn is_discontinuity(a: u32, b: u32, apart: u32) -> bool {
    if triangle_at(a) == triangle_at(b) {
        return false;
    }
    if !is_receiver(a) || !is_receiver(b) {
        return true;
    }
    let elevations = elevations_between(a, b, apart);
    return elevations.above_a > elevations.limit || elevations.above_b > elevations.limit;
}

// True if two pixels lie on one plane or nearly so, by the tangent planes of both.
fn is_level(a: u32, b: u32, apart: u32) -> bool {
    if triangle_at(a) == triangle_at(b) {
        return true;
    }
    if !is_receiver(a) || !is_receiver(b) {
        return false;
    }
    let elevations = elevations_between(a, b, apart);
    return abs(elevations.above_a) <= elevations.limit && abs(elevations.above_b) <= elevations.limit;
}
