// Commits rendered cells, per query: keeps those without a discontinuity and passes the children of the
// others on.
//@ needs shared/query_batch shared/children shared/pyramid shared/query
//@ writes queries

// True if the neighbours of refined cells are refined too, diagonal ones included.
override DIAGONAL: bool = false;

@compute @workgroup_size(64)
fn commit(here: Lane) {
    let query = query_of(invocation(here));
    if query == NONE {
        return;
    }
    let index = queries[query].place;
    let cell = cell_of(index - level_first(frame.level));
    if frame.level > 0u {
        let flagged = is_flagged(cell, index);
        let broken =
            pyramid_depth(index) > frame.depth_break || pyramid_curvature(index) > frame.curvature_break;
        if flagged || broken {
            mark_children(frame.level, cell, select(PENDING, FORCED, flagged));
            queries[query].place = NONE;
            return;
        }
    }
    cells[index].kept = KEPT;
}

fn is_flagged(cell: vec2<u32>, index: u32) -> bool {
    if !DIAGONAL {
        return cells[index].flag != 0u;
    }
    let low = cell - min(cell, vec2(1u));
    let high = min(cell + 2u, level_size(frame.level));
    for (var y = low.y; y < high.y; y++) {
        for (var x = low.x; x < high.x; x++) {
            let other = cells[cell_index(frame.level, vec2(x, y))];
            if other.state == RENDERED && other.flag != 0u {
                return true;
            }
        }
    }
    return false;
}
