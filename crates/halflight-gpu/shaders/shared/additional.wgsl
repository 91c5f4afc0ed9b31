// Additional samples of a cell, beside its first one.
//@ needs shared/cells shared/field shared/surface

// Most additional samples of the cell.
fn additional_count(owner: Owner) -> u32 {
    return select(0u, 3u, cells[owner_place(owner)].kept == KEPT_MORE);
}

// Pixel of an additional sample, which is also its index in `samples`; NONE where it does not exist.
fn additional_place(owner: Owner, number: u32) -> u32 {
    let half = 1u << (owner.level - 1u);
    let at = (owner.cell << vec2(owner.level)) + half * vec2(number & 1u, number >> 1u);
    if at.x >= frame.width || at.y >= frame.height || !is_receiver(at.y * frame.width + at.x) {
        return NONE;
    }
    return at.y * frame.width + at.x;
}
