// What a pixel's own sample tells of its lobe.
//@ needs shared/query
//@ reads samples

fn known_at(at: vec2<u32>, pixel: u32) -> u32 {
    return known_of(samples[pixel].value);
}
