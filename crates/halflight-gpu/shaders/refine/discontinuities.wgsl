// Silhouettes, steps, concave creases and, for small error targets, sharp edges between neighbouring pixels, as one light has
// them.
//@ needs shared/discontinuities shared/light shared/tangent_plane
//@ writes discontinuities

// Height in pixels above which a depth discontinuity separates unrelated surfaces.
const FAR_STEP: f32 = 32.0;
// Assumed position of an occluder between two pixels, as a fraction of their distance: it may begin anywhere
// between them.
const NEAREST: f32 = 0.05;

// Cosine of the angle between normals below which convex edges count as discontinuities.
override EDGE: f32 = -2.0;

// Position of the light relative to a tangent plane: in front, behind, on both sides.
const LIT: u32 = 0u;
const UNLIT: u32 = 1u;
const BOTH: u32 = 2u;

@compute @workgroup_size(8, 8)
fn find(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= frame.width || at.y >= frame.height {
        return;
    }
    let pixel = at.y * frame.width + at.x;
    var flags = 0u;
    if at.x + 1u < frame.width {
        flags |= flag(between(pixel, pixel + 1u), RIGHT);
    }
    if at.y + 1u < frame.height {
        flags |= flag(between(pixel, pixel + frame.width), BELOW);
    }
    discontinuities[pixel] = flags;
}

fn flag(what: u32, bit: u32) -> u32 {
    return select(0u, bit, what != NOTHING) | select(0u, bit << SHADE, what == SHADES);
}

fn between(a: u32, b: u32) -> u32 {
    if triangle_at(a) == triangle_at(b) {
        return NOTHING;
    }
    if !is_receiver(a) || !is_receiver(b) {
        return STEP;
    }
    let elevations = elevations_between(a, b, 1u);
    if elevations.above_a <= elevations.limit && elevations.above_b <= elevations.limit {
        return select(NOTHING, STEP, dot3(normal_at(a), normal_at(b)) < EDGE);
    }
    if max(elevations.above_a, elevations.above_b) > FAR_STEP * elevations.step {
        return STEP;
    }
    let sides = vec2(side(a), side(b));
    if all(sides == vec2(UNLIT)) {
        return STEP;
    }
    if any(sides != vec2(LIT)) {
        return SHADES;
    }
    // Two sides of a crease that both have all of the light in front of them.
    if elevations.above_a > 0.0 && elevations.above_b > 0.0 {
        return STEP;
    }
    return select(STEP, SHADES, hides(a, b) || hides(b, a));
}

// Side of a pixel's horizon, by its shading normal, on which the light lies.
fn side(pixel: u32) -> u32 {
    var corners = light_corners();
    let point = position[pixel].xyz;
    let up = shading_at(pixel);
    var above = 0u;
    for (var corner = 0u; corner < 4u; corner++) {
        above += u32(dot3(up, corners[corner] - point) > 0.0);
    }
    return select(select(BOTH, UNLIT, above == 0u), LIT, above == 4u);
}

// True if the surface at `other`, seen from `pixel`, is higher than some of the light in that direction.
fn hides(pixel: u32, other: u32) -> bool {
    var corners = light_corners();
    let point = position[pixel].xyz;
    let up = normal_at(pixel);
    let there = position[other].xyz - point;
    let height = dot3(up, there);
    if height <= 0.0 {
        return false;
    }
    let along = there - up * height;
    for (var corner = 0u; corner < 4u; corner++) {
        let to = corners[corner] - point;
        let forth = dot3(along, to);
        // Slopes: height over |along|, and up·to over forth/|along|.
        if forth > 0.0 && height * forth >= dot3(up, to) * dot3(along, along) * NEAREST {
            return true;
        }
    }
    return false;
}
