// Knowledge of a pixel's lobe from the pixel's own sample.
//@ needs shared/query
//@ reads samples

fn known_at(at: vec2<u32>, pixel: u32) -> u32 {
    return known_of(samples[pixel].value);
}
