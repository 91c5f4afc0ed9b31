// Counts receivers by cell and removes the samples below their horizons, per query. Receivers that are too
// near the light's plane are left to rays; those behind the light are answered.
//@ needs shared/query_batch shared/query shared/tally visibility/horizon visibility/raster4d_bounds
//@ reads queries
//@ writes wanted visible bins spilled

@compute @workgroup_size(64)
fn count_receivers(here: Lane) {
    let query = query_of(invocation(here));
    if query != NONE {
        let pixel = queries[query].pixel;
        let cell = cell_of(pixel);
        atomicStore(&bins[cells_of_queries() + query], cell);
        if pixel == NONE {
            answer_nothing(query);
        } else if cell == NONE && any(facing(receiver_at(pixel).origin) != vec3(0.0)) {
            let place = atomicAdd(&spilled[0], 1u);
            atomicStore(&spilled[1u + place], query);
        } else {
            if cell != NONE {
                atomicAdd(&bins[receiver_ends() + cell], 1u);
            }
            take_out(query);
        }
    }
    workgroupBarrier();
    tally(here);
}

fn cell_of(pixel: u32) -> u32 {
    if pixel == NONE {
        return NONE;
    }
    let origin = receiver_at(pixel).origin;
    let side = side_of(origin);
    let p = local(origin, side);
    if side >= frame.sides || !is_projected(p) {
        return NONE;
    }
    let at = cell_at(squeezed(slope(p, 0.0)), bounds(side));
    return (side * FRAMEBUFFER + at.y) * FRAMEBUFFER + at.x;
}

fn answer_nothing(query: u32) {
    for (var word = 0u; word < frame.pattern.words; word++) {
        wanted[query * frame.pattern.words + word] = 0u;
        visible[query * frame.pattern.words + word] = 0u;
    }
}

// Removes the samples below the horizons and beside the light; all others are visible until a triangle hides them.
fn take_out(query: u32) {
    let receiver = receiver_at(queries[query].pixel);
    for (var word = 0u; word < frame.pattern.words; word++) {
        let slot = query * frame.pattern.words + word;
        let asked = wanted[slot];
        var above = asked;
        for (var left = asked; left != 0u; left &= left - 1u) {
            let index = firstTrailingBit(left);
            let place = sample_place(word * 32u + index, queries[query].key);
            if !adds_light(receiver, place, light_point(place)) {
                above ^= 1u << index;
            }
        }
        wanted[slot] = above;
        visible[slot] = above;
        atomicAdd(&traced, countOneBits(above));
        atomicAdd(&skipped, countOneBits(asked ^ above));
    }
}
