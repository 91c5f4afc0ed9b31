// Knowledge of a pixel's lobe from the samples of its cell: lit or dark where all of them are.
//@ needs shared/additional

fn known_at(at: vec2<u32>, pixel: u32) -> u32 {
    let owner = owner_at(at);
    if owner.level == NONE {
        return OPEN;
    }
    let known = known_sample(owner_place(owner));
    let more = additional_count(owner);
    for (var number = 0u; number < more; number++) {
        let place = additional_place(owner, number);
        if place != NONE && known_sample(place) != known {
            return OPEN;
        }
    }
    return known;
}
