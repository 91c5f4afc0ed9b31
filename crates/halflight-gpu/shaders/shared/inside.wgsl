//@ needs shared/discontinuities
//@ reads discontinuities

// What lies between the pixels of a cell, with those of its corners that belong to the cells right of and below it.
fn discontinuities_inside(level: u32, cell: vec2<u32>) -> u32 {
    if level == 0u {
        return NOTHING;
    }
    var flags = discontinuities[cell_index(level, cell)];
    // The last corner neighbours none of the cell's own pixels, but the one left of it does.
    let beyond = (cell + 1u) << vec2(level);
    if beyond.x < frame.width && beyond.y < frame.height {
        flags |= discontinuities[beyond.y * frame.width + beyond.x - 1u] & (RIGHT | (RIGHT << SHADE));
    }
    if flags == 0u {
        return NOTHING;
    }
    return select(SHADES, STEP, (flags >> SHADE) == 0u);
}
