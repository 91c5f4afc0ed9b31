// Visible fractions of pixels: their bits plus one, or 0 where undefined or not traced; the accessor returns
// a negative number for these. The second word holds the bits of the expected squared error.
//@ needs shared/corners
//@ reads fractions

fn fraction_at(pixel: u32) -> f32 {
    let bits = fractions[pixel].x;
    return select(bitcast<f32>(max(bits, 1u) - 1u), -1.0, bits == 0u);
}

fn variance_at(pixel: u32) -> f32 {
    return bitcast<f32>(fractions[pixel].y);
}

fn corner_fractions(corners: Corners) -> vec4<f32> {
    return vec4(
        fraction_at(pixel_of(corner_at(corners, 0u))),
        fraction_at(pixel_of(corner_at(corners, 1u))),
        fraction_at(pixel_of(corner_at(corners, 2u))),
        fraction_at(pixel_of(corner_at(corners, 3u))),
    );
}
