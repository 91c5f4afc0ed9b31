// Knowledge of a lobe from the visible fraction of a sample.
//@ needs shared/query
//@ reads samples

fn known_sample(place: u32) -> u32 {
    return known_of(samples[place].value);
}
