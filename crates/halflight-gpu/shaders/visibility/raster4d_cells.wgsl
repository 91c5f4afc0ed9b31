// Cells of a triangle packed into one word, so that counting and filling use identical cells.
//@ needs visibility/raster4d

// Packs the level, the first cell and, for both axes, a bit for a second cell.
fn packed_cells(level: u32, low: vec2<u32>, high: vec2<u32>) -> u32 {
    let wide = high - low;
    return level | (low.x << 4u) | (low.y << 14u) | (wide.x << 24u) | (wide.y << 25u);
}

// Index of one of up to four cells, among those of all levels and sides; NONE where there is none.
fn cell_at_corner(cells: u32, corner: u32, side: u32) -> u32 {
    let additional = vec2(corner & 1u, corner >> 1u);
    if cells == NONE || any(additional > vec2((cells >> 24u) & 1u, (cells >> 25u) & 1u)) {
        return NONE;
    }
    let level = cells & 15u;
    let at = vec2((cells >> 4u) & 1023u, (cells >> 14u) & 1023u) + additional;
    var first = side * CELLS;
    for (var finer = 0u; finer < level; finer++) {
        first += level_side(finer) * level_side(finer);
    }
    return first + at.y * level_side(level) + at.x;
}
