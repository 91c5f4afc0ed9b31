// Silhouettes, steps, concave creases and, for small error targets, sharp edges between neighbouring pixels, as one light has
// them.
//@ needs shared/discontinuities shared/light shared/tangent_plane
//@ writes discontinuities

// Steps higher than this many pixels have nothing in common with what is behind them.
const FAR_STEP: f32 = 32.0;
// What stands in the way begins anywhere between two pixels: it is taken to be this near.
const NEAREST: f32 = 0.05;

// Cosine of the turn from which convex edges are taken for steps.
override EDGE: f32 = -2.0;

// Where the light is: in front, behind, on both sides.
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
    let rises = rises_between(a, b, 1u);
    if rises.above_a <= rises.limit && rises.above_b <= rises.limit {
        return select(NOTHING, STEP, dot3(normal_at(a), normal_at(b)) < EDGE);
    }
    if max(rises.above_a, rises.above_b) > FAR_STEP * rises.step {
        return STEP;
    }
    let sides = vec2(side(a), side(b));
    if all(sides == vec2(UNLIT)) {
        return STEP;
    }
    if any(sides != vec2(LIT)) {
        return SHADES;
    }
    // Two sides of a crease that both have all of the light before them.
    if rises.above_a > 0.0 && rises.above_b > 0.0 {
        return STEP;
    }
    return select(STEP, SHADES, hides(a, b) || hides(b, a));
}

// Which side of a pixel's plane the light is on.
fn side(pixel: u32) -> u32 {
    var corners = light_corners();
    let point = position[pixel].xyz;
    let up = normal_at(pixel);
    var above = 0u;
    for (var corner = 0u; corner < 4u; corner++) {
        above += u32(dot3(up, corners[corner] - point) > 0.0);
    }
    return select(select(BOTH, UNLIT, above == 0u), LIT, above == 4u);
}

// Whether what is seen at `other` stands, as seen from `pixel`, higher than some of the light in that direction.
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
