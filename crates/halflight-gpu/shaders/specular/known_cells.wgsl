// Knowledge of a pixel's lobe from the samples of its cell: lit or dark where all of them are.
//@ needs shared/additional shared/query
//@ reads samples

fn known_at(at: vec2<u32>, pixel: u32) -> u32 {
    let owner = owner_at(at);
    if owner.level == NONE {
        return OPEN;
    }
    let known = known_of(samples[owner_place(owner)].value);
    let more = additional_count(owner);
    for (var number = 0u; number < more; number++) {
        let place = additional_place(owner, number);
        if place != NONE && known_of(samples[place].value) != known {
            return OPEN;
        }
    }
    return known;
}
