// Knowledge of a lobe from the visible fractions of a sample by channel: none where they differ. Samples that no query has
// answered have one value for all channels.
//@ needs shared/query
//@ reads samples channels

// True if the smoothed values count, which follow the others.
override SMOOTHED: bool = false;

fn known_sample(place: u32) -> u32 {
    let found = channels[place + select(0u, arrayLength(&channels) / 2u, SMOOTHED)];
    if found.w == 0.0 {
        return known_of(samples[place].value);
    }
    let known = known_of(found.x);
    return select(OPEN, known, all(found.yz == found.xx));
}
