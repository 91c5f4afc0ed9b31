// Closes cracks between levels, per cell of a level: splits kept cells whose interpolated values differ from
// corners of finer cells by more than the tolerance.
//@ needs shared/children shared/visible_tolerance

@compute @workgroup_size(8, 8)
fn close_cracks(@builtin(global_invocation_id) at: vec3<u32>) {
    if any(at.xy >= level_size(frame.level)) || frame.level > frame.coarsest {
        return;
    }
    let index = cell_index(frame.level, at.xy);
    if cells[index].kept == 0u || meets_neighbours(corners_of(frame.level, at.xy)) {
        return;
    }
    cells[index].kept = 0u;
    mark_children(frame.level, at.xy, PENDING);
}

// True if the cell agrees with finer corners along its four edges, and just outside the left and the top one.
// Pixels just outside the right and the bottom edge lie on edges of the next cells.
fn meets_neighbours(corners: Corners) -> bool {
    let known = corner_fractions(corners);
    let tolerance = tolerance_between(corners, known);
    let first = corners.first;
    let last = corners.last;
    for (var x = first.x; x <= last.x; x++) {
        if first.y > 0u && !agrees(corners, known, tolerance, vec2(x, first.y - 1u)) {
            return false;
        }
        if x > first.x && x < last.x
            && !(agrees(corners, known, tolerance, vec2(x, first.y)) && agrees(corners, known, tolerance, vec2(x, last.y))) {
            return false;
        }
    }
    for (var y = first.y; y <= last.y; y++) {
        if first.x > 0u && !agrees(corners, known, tolerance, vec2(first.x - 1u, y)) {
            return false;
        }
        if y > first.y && y < last.y
            && !(agrees(corners, known, tolerance, vec2(first.x, y)) && agrees(corners, known, tolerance, vec2(last.x, y))) {
            return false;
        }
    }
    return true;
}

fn agrees(corners: Corners, known: vec4<f32>, tolerance: f32, at: vec2<u32>) -> bool {
    let found = fraction_at(pixel_of(at));
    if found < 0.0 {
        return true;
    }
    let expected = interpolated(corners, known, at);
    // Without corners on the pixel's surface, no comparison is possible.
    return !expected.exists || abs(found - expected.value) <= tolerance;
}
