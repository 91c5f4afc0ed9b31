// Corners of a cell (halflight-cpu/src/corners.rs): its first pixel and the first pixels of the cells right
// of and below it, clamped to the image's last column and row. All corners of a single-pixel cell are the
// pixel itself.
//@ needs shared/tangent_plane

struct Corners {
    first: vec2<u32>,
    last: vec2<u32>,
}

// Value that may be undefined.
struct Maybe {
    exists: bool,
    value: f32,
}

fn corners_of(level: u32, cell: vec2<u32>) -> Corners {
    let first = cell << vec2(level);
    let size = select(0u, 1u << level, level > 0u);
    return Corners(first, min(first + size, vec2(frame.width, frame.height) - 1u));
}

// Top left, top right, bottom left, bottom right.
fn corner_at(corners: Corners, number: u32) -> vec2<u32> {
    return select(corners.first, corners.last, vec2((number & 1u) == 1u, number > 1u));
}

fn pixel_of(at: vec2<u32>) -> u32 {
    return at.y * frame.width + at.x;
}

// Distance of two pixels in columns or rows, whichever is larger.
fn apart(a: vec2<u32>, b: vec2<u32>) -> u32 {
    let off = max(a, b) - min(a, b);
    return max(off.x, off.y);
}

// Bilinear weights of the corners at a pixel; extrapolated where the pixel does not lie between them.
fn bilinear_weights(corners: Corners, at: vec2<u32>) -> vec4<f32> {
    let size = vec2<f32>(max(corners.last - corners.first, vec2(1u)));
    let place = (vec2<f32>(at) - vec2<f32>(corners.first)) * (1.0 / size);
    let rest = 1.0 - place;
    return vec4(rest.x * rest.y, place.x * rest.y, rest.x * place.y, place.x * place.y);
}

// Value at a pixel: bilinear between the corners that no surface discontinuity separates from it and whose
// value is defined (not negative).
fn interpolated(corners: Corners, values: vec4<f32>, at: vec2<u32>) -> Maybe {
    let weights = bilinear_weights(corners, at);
    let pixel = pixel_of(at);
    var sum = 0.0;
    var total = 0.0;
    var plain = 0.0;
    var count = 0.0;
    for (var number = 0u; number < 4u; number++) {
        let corner = corner_at(corners, number);
        if values[number] < 0.0 || is_discontinuity(pixel, pixel_of(corner), apart(corner, at)) {
            continue;
        }
        sum += weights[number] * values[number];
        total += weights[number];
        plain += values[number];
        count += 1.0;
    }
    // The remaining corners may have a weight of almost zero.
    if total > 1e-3 {
        return Maybe(true, sum / total);
    }
    return Maybe(count > 0.0, plain / max(count, 1.0));
}
