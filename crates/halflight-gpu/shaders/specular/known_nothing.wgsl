// Sampled irradiance tells nothing of a pixel's lobe.

fn known_at(at: vec2<u32>, pixel: u32) -> u32 {
    return OPEN;
}
