// Knowledge of a pixel's lobe from the pixel's own sample.

fn known_at(at: vec2<u32>, pixel: u32) -> u32 {
    return known_sample(pixel);
}
