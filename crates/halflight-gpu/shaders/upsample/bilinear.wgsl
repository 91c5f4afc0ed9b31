// Multi-pass bilinear upsampling (Nichols10 §3.4), per texel of a level: from the next coarser level to this
// one; level 0 writes pixels.
//@ needs shared/counters shared/query shared/tangent
//@ reads samples owners
//@ writes plane texels

struct Texel {
    // Negative where not computed.
    value: f32,
    // Representative pixel, or NONE.
    pixel: u32,
}

const EMPTY: Texel = Texel(-1.0, 0xffffffffu);

@compute @workgroup_size(8, 8)
fn bilinear(@builtin(global_invocation_id) at: vec3<u32>) {
    let size = level_size(frame.level);
    if at.x >= size.x || at.y >= size.y {
        return;
    }
    let found = texel(at.xy);
    if frame.level == 0u {
        plane[at.y * frame.width + at.x] = max(found.value, 0.0);
    } else {
        texels[cell_index(frame.level, at.xy)] = found;
    }
}

fn texel(at: vec2<u32>) -> Texel {
    if frame.level == 0u && !is_receiver(at.y * frame.width + at.x) {
        return EMPTY;
    }
    let corner = at << vec2(frame.level);
    let owner = owners[corner.y * frame.width + corner.x];
    if owner == NONE || owner < frame.level {
        return EMPTY;
    }
    if owner == frame.level {
        let own = samples[cell_index(frame.level, at)];
        if own.value >= 0.0 {
            return Texel(own.value, own.pixel);
        }
    }
    if frame.level >= atomicLoad(&counters[TOP]) {
        return EMPTY;
    }
    return interpolated(at);
}

// Edge-aware interpolation between the four nearest texels of the next coarser level.
fn interpolated(at: vec2<u32>) -> Texel {
    let coarse = level_size(frame.level + 1u);
    let parent = at / 2u;
    // Neighbour on the texel's own side; at the border the parent again.
    let side = select(parent - min(parent, vec2(1u)), min(parent + 1u, coarse - 1u), (at & vec2(1u)) == vec2(1u));
    var taps = array(
        texels[cell_index(frame.level + 1u, parent)],
        texels[cell_index(frame.level + 1u, vec2(side.x, parent.y))],
        texels[cell_index(frame.level + 1u, vec2(parent.x, side.y))],
        texels[cell_index(frame.level + 1u, side)],
    );
    var weights = vec4(9.0, 3.0, 3.0, 1.0);
    var pixel = stand_in(at);
    if pixel == NONE {
        pixel = taps[0].pixel;
    }
    let first = taps[0].value;
    if first >= 0.0 && first == taps[1].value && first == taps[2].value && first == taps[3].value {
        return Texel(first, pixel);
    }
    var sum = 0.0;
    var total = 0.0;
    var plain = 0.0;
    var plain_total = 0.0;
    for (var number = 0u; number < 4u; number++) {
        let tap = taps[number];
        if tap.value < 0.0 {
            continue;
        }
        plain += weights[number] * tap.value;
        plain_total += weights[number];
        if pixel == NONE || tap.pixel == NONE {
            continue;
        }
        var weight = weights[number];
        if triangle_at(pixel) != triangle_at(tap.pixel) || triangle_at(pixel) == NONE {
            weight *= agreement(tangent_at(pixel), tangent_at(tap.pixel));
        }
        sum += weight * tap.value;
        total += weight;
    }
    if total > 0.0 {
        return Texel(sum / total, pixel);
    }
    return Texel(select(-1.0, plain / plain_total, plain_total > 0.0), pixel);
}

// Representative pixel of a texel, right of and below its centre, if it sees geometry.
fn stand_in(at: vec2<u32>) -> u32 {
    let size = 1u << frame.level;
    let centre = min(at * size + size / 2u, vec2(frame.width, frame.height) - 1u);
    let pixel = centre.y * frame.width + centre.x;
    return select(NONE, pixel, is_receiver(pixel));
}
