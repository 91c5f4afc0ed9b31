// Knowledge of a pixel's lobe from the corners of its cell: lit or dark where all of them are.
//@ needs shared/corners shared/field

fn known_at(at: vec2<u32>, pixel: u32) -> u32 {
    let owner = owner_at(at);
    if owner.level == NONE {
        return OPEN;
    }
    if owner.level == 0u {
        return known_sample(pixel);
    }
    let corners = corners_of(owner.level, owner.cell);
    var known = NONE;
    for (var number = 0u; number < 4u; number++) {
        let corner = pixel_of(corner_at(corners, number));
        if !is_receiver(corner) {
            continue;
        }
        let found = known_sample(corner);
        if found == OPEN || (known != NONE && known != found) {
            return OPEN;
        }
        known = found;
    }
    return min(known, OPEN);
}
