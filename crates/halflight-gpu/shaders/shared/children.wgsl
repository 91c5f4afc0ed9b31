// Propagation of a state to child cells.
//@ needs shared/cells
//@ writes cells

// Sets the state of the four children of a cell.
fn mark_children(level: u32, cell: vec2<u32>, state: u32) {
    let size = level_size(level - 1u);
    for (var child = 0u; child < 4u; child++) {
        let at = 2u * cell + vec2(child & 1u, child >> 1u);
        if all(at < size) {
            cells[cell_index(level - 1u, at)].state = state;
        }
    }
}
