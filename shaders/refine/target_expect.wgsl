// Expected squared error of the irradiance that one light adds, by luminance: by what the masks at the corners of cells show
// (halflight-cpu/src/refine/lattice/foretell.rs).
//@ needs shared/fractions shared/tiles shared/unshadowed
//@ reads owners

// Mean square error of a cell's pixels over the square of the difference between its corners, as on the CPU.
const CURVATURE: f32 = 0.06;

@compute @workgroup_size(8, 8)
fn expect(here: Tile) {
    var share = 0.0;
    if here.at.x < frame.width && here.at.y < frame.height {
        let level = owners[pixel_of(here.at.xy)];
        // The first pixel of a cell speaks for it.
        if level != NONE && all(((here.at.xy >> vec2(level)) << vec2(level)) == here.at.xy) {
            share = expected(level, here.at.xy);
        }
    }
    let power = luminance(frame.radiance);
    add_up(here, share * power * power);
}

fn expected(level: u32, first: vec2<u32>) -> f32 {
    let corners = corners_of(level, first >> vec2(level));
    let size = corners.last - corners.first;
    var low = 1.0;
    var high = 0.0;
    var variance = 0.0;
    var known = 0.0;
    var bright = 0.0;
    var count = 0.0;
    for (var number = 0u; number < 4u; number++) {
        let pixel = pixel_of(corner_at(corners, number));
        let again = ((number & 1u) == 1u && size.x == 0u) || (number > 1u && size.y == 0u);
        if again || !is_receiver(pixel) {
            continue;
        }
        let receiver = receiver_at(pixel);
        let unshaded = unshadowed(receiver.origin, receiver.normal);
        bright += unshaded * unshaded;
        count += 1.0;
        let fraction = fraction_at(pixel);
        if fraction >= 0.0 {
            low = min(low, fraction);
            high = max(high, fraction);
            variance += variance_at(pixel);
            known += 1.0;
        }
    }
    if known == 0.0 {
        return 0.0;
    }
    variance /= known;
    if level > 0u {
        // Bilinear weights squared have a mean sum of 4/9.
        let range = min(high - low, frame.error);
        variance = variance * (4.0 / 9.0) + CURVATURE * range * range;
    }
    let pixels = min(vec2(1u << level), vec2(frame.width, frame.height) - first);
    return variance * (bright / count) * f32(pixels.x * pixels.y);
}
