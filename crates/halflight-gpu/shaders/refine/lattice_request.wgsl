// Requests masks, per corner of a level's cells: from waiting cells to queries, for corners that have none
// yet. Tiles of 8 × 8 corners stay together.
//@ needs shared/append shared/cells shared/query_mask shared/surface
//@ writes cells

// 1 if requested masks count as samples; 0 for pilot samples.
override COUNTED: u32 = 1u;

@compute @workgroup_size(8, 8)
fn request(here: Tile) {
    let place = min(here.at.xy << vec2(frame.level), vec2(frame.width, frame.height) - 1u);
    let pixel = place.y * frame.width + place.x;
    let asks = is_wanted(here.at.xy) && is_receiver(pixel) && cells[pixel].slot == 0u;
    let slot = append(here.lane, asks, QUERIES, frame.capacity);
    if here.lane == 0u && COUNTED == 1u {
        atomicAdd(&counters[pixel_bucket(here.workgroup)], appended());
    }
    if slot == NONE {
        return;
    }
    cells[pixel].slot = 1u;
    ask_all(slot, pixel);
}

// True if one of the cells around a corner waits for it. Of corners that coincide at the image's border only
// the first is wanted.
fn is_wanted(corner: vec2<u32>) -> bool {
    let size = level_size(frame.level);
    if frame.level == 0u {
        return all(corner < size) && waits(corner);
    }
    let last = vec2(frame.width, frame.height) - 1u;
    if any(corner > size) || any((corner > vec2(0u)) & (((corner - 1u) << vec2(frame.level)) >= last)) {
        return false;
    }
    let before = corner - min(corner, vec2(1u));
    return waits(before) || waits(vec2(corner.x, before.y)) || waits(vec2(before.x, corner.y)) || waits(corner);
}

fn waits(cell: vec2<u32>) -> bool {
    return all(cell < level_size(frame.level)) && cells[cell_index(frame.level, cell)].state == WAITING;
}
