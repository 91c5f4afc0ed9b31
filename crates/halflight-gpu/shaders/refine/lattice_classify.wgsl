// Classifies pending cells by geometry alone, per cell of a level: from discontinuities to split cells and
// cells that wait for their corners' masks.
//@ needs shared/children shared/corners shared/inside

@compute @workgroup_size(8, 8)
fn classify(@builtin(global_invocation_id) at: vec3<u32>) {
    // If every pixel is traced there are no coarser cells.
    if any(at.xy >= level_size(frame.level)) || frame.level > frame.coarsest {
        return;
    }
    let index = cell_index(frame.level, at.xy);
    let state = cells[index].state;
    if state != PENDING && !(state == 0u && frame.level == frame.coarsest) {
        return;
    }
    let corners = corners_of(frame.level, at.xy);
    let strongest = discontinuities_inside(frame.level, at.xy);
    if strongest == NOTHING {
        // Without a discontinuity all of the cell's pixels see geometry if one of them does.
        cells[index].state = select(DONE, WAITING, is_receiver(pixel_of(corners.first)));
        return;
    }
    if strongest == STEP && frame.level <= frame.step_level && serves(corners, at.xy) {
        cells[index].state = WAITING;
        return;
    }
    cells[index].state = DONE;
    mark_children(frame.level, at.xy, PENDING);
}

// True if every pixel of a cell that sees geometry has a corner on its surface.
fn serves(corners: Corners, cell: vec2<u32>) -> bool {
    let first = cell << vec2(frame.level);
    let last = min(first + (1u << frame.level), vec2(frame.width, frame.height));
    for (var y = first.y; y < last.y; y++) {
        for (var x = first.x; x < last.x; x++) {
            if is_receiver(pixel_of(vec2(x, y))) && !is_served(corners, vec2(x, y)) {
                return false;
            }
        }
    }
    return true;
}

fn is_served(corners: Corners, at: vec2<u32>) -> bool {
    for (var number = 0u; number < 4u; number++) {
        let corner = corner_at(corners, number);
        if is_level(pixel_of(at), pixel_of(corner), apart(corner, at)) {
            return true;
        }
    }
    return false;
}
