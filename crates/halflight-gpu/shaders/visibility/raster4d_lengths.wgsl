// Counts the triangles over each of the finest cells on all levels, per cell.
//@ needs visibility/raster4d
//@ writes bins

@compute @workgroup_size(64)
fn measure(here: Lane) {
    let cell = invocation(here);
    if cell >= finest_cells() {
        return;
    }
    let side = cell / (FRAMEBUFFER * FRAMEBUFFER);
    let at = vec2(cell % FRAMEBUFFER, (cell / FRAMEBUFFER) % FRAMEBUFFER);
    var first = side * CELLS;
    var length = 0u;
    for (var level = 0u; level < LEVELS; level++) {
        let over = first + (at.y >> level) * level_side(level) + (at.x >> level);
        first += level_side(level) * level_side(level);
        length += atomicLoad(&bins[TRIANGLE_ENDS + over]);
        if over > 0u {
            length -= atomicLoad(&bins[TRIANGLE_ENDS + over - 1u]);
        }
    }
    atomicStore(&bins[lengths() + cell], length);
}
