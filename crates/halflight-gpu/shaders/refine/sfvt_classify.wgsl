// Classifies pending cells by geometry (Koa17 §3.3), per cell of a level: splits some, keeps unlit ones, and
// requests the masks of the others' sub-fragments.
//@ needs shared/append shared/children shared/representative shared/pyramid shared/query_mask
//@ writes samples

@compute @workgroup_size(64)
fn classify(here: Lane) {
    let cell = cell_of(invocation(here));
    var asks = false;
    if cell.y < level_size(frame.level).y {
        asks = is_tested(cell);
    }
    let slot = append(here.index, asks, QUERIES, frame.capacity / frame.slots);
    if slot == NONE {
        return;
    }
    let index = cell_index(frame.level, cell);
    let fragment = fold((frame.level << 16u) | cell.y, cell.x);
    let size = 1u << frame.level;
    for (var part = 0u; part < frame.slots; part++) {
        let query = slot * frame.slots + part;
        // Slots are ordered by quadrant; of sixteen, four belong to a quadrant.
        var square = size / 2u;
        var corner = cell * size;
        if frame.slots == 16u {
            corner = quadrant_corner(corner, square, part / 4u);
            square /= 2u;
            corner = quadrant_corner(corner, square, part % 4u);
        } else {
            corner = quadrant_corner(corner, square, part);
        }
        let pixel = fragment_point(corner, square);
        var asked = 0u;
        for (var word = 0u; word < frame.pattern.words; word++) {
            var mask = 0u;
            if pixel != NONE {
                mask = full_word(word);
                // Of sixteen, the same part of each quadrant has the same samples.
                if frame.slots == 16u {
                    mask = share_word(word, part % 4u);
                }
            }
            asked += countOneBits(mask);
            wanted[query * frame.pattern.words + word] = mask;
        }
        // The first query refers to the cell until the split test.
        queries[query] = Query(pixel, pattern_key(fragment, pixel), asked, index);
    }
}

fn quadrant_corner(corner: vec2<u32>, half: u32, quadrant: u32) -> vec2<u32> {
    return corner + half * vec2(quadrant & 1u, quadrant >> 1u);
}

fn is_tested(cell: vec2<u32>) -> bool {
    let level = frame.level;
    let index = cell_index(level, cell);
    if (cells[index].state != PENDING && level != frame.coarsest) || !pyramid_has_receiver(index) {
        return false;
    }
    let curved = pyramid_curvature(index) > frame.curvature_break;
    if curved || (pyramid_depth(index) > frame.depth_break && level > frame.depth_finest) {
        mark_children(level, cell, PENDING);
        return false;
    }
    if cell_faces_away(level, cell) {
        let pixel = fragment_point(cell << vec2(level), 1u << level);
        if pixel != NONE {
            cells[index].kept = KEPT;
            samples[index] = unlit(pixel);
        }
        return false;
    }
    return true;
}
