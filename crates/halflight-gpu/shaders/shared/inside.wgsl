// Discontinuities inside cells.
//@ needs shared/discontinuities
//@ reads discontinuities

// Strongest discontinuity among the pixels of a cell and those of its corners that belong to the cells right
// of and below it.
fn discontinuities_inside(level: u32, cell: vec2<u32>) -> u32 {
    if level == 0u {
        return NOTHING;
    }
    var flags = discontinuities[cell_index(level, cell)];
    // The last corner has no neighbour among the cell's own pixels, but the corner's left neighbour is next
    // to one.
    let beyond = (cell + 1u) << vec2(level);
    if beyond.x < frame.width && beyond.y < frame.height {
        flags |= discontinuities[beyond.y * frame.width + beyond.x - 1u] & (RIGHT | (RIGHT << SHADE));
    }
    if flags == 0u {
        return NOTHING;
    }
    return select(SHADES, STEP, (flags >> SHADE) == 0u);
}
