// Split test, per waiting cell of a level: from the visible fractions of its corners to kept or split.
//@ needs shared/children shared/inside shared/representative shared/visible_tolerance

@compute @workgroup_size(8, 8)
fn split_test(@builtin(global_invocation_id) at: vec3<u32>) {
    if any(at.xy >= level_size(frame.level)) {
        return;
    }
    let index = cell_index(frame.level, at.xy);
    if cells[index].state != WAITING {
        return;
    }
    cells[index].state = DONE;
    if frame.level == 0u || passes_split_test(at.xy) {
        cells[index].kept = KEPT;
    } else {
        mark_children(frame.level, at.xy, PENDING);
    }
}

fn passes_split_test(cell: vec2<u32>) -> bool {
    let corners = corners_of(frame.level, cell);
    let found = corner_fractions(corners);
    if discontinuities_inside(frame.level, cell) == STEP {
        return passes_step_test(corners, found);
    }
    let missing = dot(vec4<u32>(found < vec4(0.0)), vec4(1u));
    if missing == 4u {
        return is_unlit(cell);
    }
    if missing > 0u {
        return false;
    }
    let low = min(min(found.x, found.y), min(found.z, found.w));
    let high = max(max(found.x, found.y), max(found.z, found.w));
    let tolerance = tolerance_between(corners, found);
    return high - low <= tolerance || is_predicted(cell, corners, found, tolerance);
}

// True if the parent's corners predicted this cell's fractions.
fn is_predicted(cell: vec2<u32>, corners: Corners, found: vec4<f32>, tolerance: f32) -> bool {
    if frame.level >= frame.coarsest || discontinuities_inside(frame.level + 1u, cell / 2u) != NOTHING {
        return false;
    }
    let parent = corners_of(frame.level + 1u, cell / 2u);
    let known = corner_fractions(parent);
    for (var number = 0u; number < 4u; number++) {
        let expected = interpolated(parent, known, corner_at(corners, number));
        // Without a fraction at the parent's corners there is no prediction.
        if !expected.exists || abs(expected.value - found[number]) > tolerance {
            return false;
        }
    }
    return true;
}

// True if no pixel of the cell faces the light.
fn is_unlit(cell: vec2<u32>) -> bool {
    let first = cell << vec2(frame.level);
    let last = min(first + (1u << frame.level), vec2(frame.width, frame.height));
    for (var y = first.y; y < last.y; y++) {
        for (var x = first.x; x < last.x; x++) {
            if !faces_away(y * frame.width + x) {
                return false;
            }
        }
    }
    return true;
}

// True if a cell across a depth discontinuity can be interpolated: corners on one surface agree, and a corner
// that is alone on its surface is fully lit or in umbra.
fn passes_step_test(corners: Corners, found: vec4<f32>) -> bool {
    let tolerance = tolerance_between(corners, found);
    for (var one = 0u; one < 4u; one++) {
        let here = corner_at(corners, one);
        if !is_receiver(pixel_of(here)) {
            continue;
        }
        var alone = true;
        for (var other = 0u; other < 4u; other++) {
            let there = corner_at(corners, other);
            if all(here == there) || is_discontinuity(pixel_of(here), pixel_of(there), apart(here, there)) {
                continue;
            }
            alone = false;
            // Negative values are undefined: two undefined ones agree, a defined and an undefined one do not.
            let both = found[one] >= 0.0 && found[other] >= 0.0;
            let neither = found[one] < 0.0 && found[other] < 0.0;
            if !(neither || (both && abs(found[one] - found[other]) <= tolerance)) {
                return false;
            }
        }
        let plain = found[one] <= 0.0 || found[one] == 1.0;
        if alone && !(plain && frame.level == 1u) {
            return false;
        }
    }
    return true;
}
