// Selects the pending cells that are rendered at this level (Nichols10 §3.4), per cell: from the pyramid to
// queries. Of the other cells, some go on to the next level, some are unlit, and some are empty.
//@ needs shared/append shared/children shared/representative shared/pyramid shared/query_mask
//@ writes samples

override INTERLEAVED: bool = false;

@compute @workgroup_size(64)
fn choose(here: Lane) {
    let cell = cell_of(invocation(here));
    var pixel = NONE;
    if cell.y < level_size(frame.level).y {
        pixel = chosen(cell);
    }
    let slot = append(here.index, pixel != NONE, QUERIES, frame.capacity);
    if slot == NONE {
        return;
    }
    let index = cell_index(frame.level, cell);
    cells[index].state = RENDERED;
    cells[index].slot = slot;
    samples[index] = Sample(pixel_centre(pixel), NO_VALUE, pixel);
    var asked = 0u;
    for (var word = 0u; word < frame.pattern.words; word++) {
        var mask = full_word(word);
        if INTERLEAVED {
            mask = share_word(word, (cell.x & 1u) | ((cell.y & 1u) << 1u));
        }
        wanted[slot * frame.pattern.words + word] = mask;
        asked += countOneBits(mask);
    }
    queries[slot] = Query(pixel, fold(frame.key, 0u), asked, index);
}

// Representative pixel of a cell that is rendered, or NONE.
fn chosen(cell: vec2<u32>) -> u32 {
    let level = frame.level;
    let index = cell_index(level, cell);
    var state = cells[index].state;
    // Above the coarsest level everything counts as discontinuous, or refinement would never start.
    if level == frame.coarsest {
        state = PENDING;
    }
    if state == 0u {
        return NONE;
    }
    if level == 0u {
        let pixel = cell.y * frame.width + cell.x;
        if !is_receiver(pixel) {
            return NONE;
        }
        if cell_faces_away(0u, cell) {
            keep_unlit(index, pixel);
            return NONE;
        }
        return pixel;
    }
    if !pyramid_has_receiver(index) {
        return NONE;
    }
    let broken = pyramid_depth(index) > frame.depth_break || pyramid_curvature(index) > frame.curvature_break;
    if broken && state != FORCED {
        mark_children(level, cell, PENDING);
        return NONE;
    }
    let pixel = fragment_point(cell << vec2(level), 1u << level);
    if pixel == NONE {
        return NONE;
    }
    if !broken && cell_faces_away(level, cell) {
        keep_unlit(index, pixel);
        return NONE;
    }
    return pixel;
}

fn keep_unlit(index: u32, pixel: u32) {
    cells[index].kept = KEPT;
    samples[index] = unlit(pixel);
}
