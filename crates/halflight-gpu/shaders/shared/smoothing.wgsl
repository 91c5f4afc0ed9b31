// Smoothed visible fraction of a pixel with a mask (halflight-cpu/src/refine/lattice/denoise.rs).
//@ needs shared/fractions shared/query

const DIRECTIONS = array(vec2(1i, 0i), vec2(0i, 1i), vec2(1i, 1i), vec2(1i, -1i));
const STRIDES = array(1i, 2i, 4i, 8i, 16i);

// Most standard deviations by which a pair differs from a single sample, and from the mean of several.
const FROM_ONE: f32 = 3.0;
const FROM_SEVERAL: f32 = 2.0;

// Standard deviation of the fraction of a mask whose samples all agree, in samples.
const AGREED: f32 = 0.4;

// Fractions and expected squared errors, summed.
struct Sum {
    fractions: f32,
    variances: f32,
    count: f32,
}

struct Smoothed {
    sum: Sum,
    // True if the fractions that were summed are not all the same.
    varies: bool,
    // Bit 4 · stride + direction of every pair that was added, by their indices.
    pairs: u32,
}

fn smoothed(at: vec2<u32>) -> Smoothed {
    let pixel = pixel_of(at);
    let own = fraction_at(pixel);
    var directions = DIRECTIONS;
    var strides = STRIDES;
    var sum = Sum(own, noise_at(pixel), 1.0);
    var varies = own > 0.0 && own < 1.0;
    var closed = 0u;
    var pairs = 0u;
    for (var stride = 0u; stride < 5u; stride++) {
        var ring = Sum(0.0, 0.0, 0.0);
        for (var direction = 0u; direction < 4u; direction++) {
            if (closed & (1u << direction)) != 0u {
                continue;
            }
            let off = directions[direction] * strides[stride];
            let a = neighbour(at, off);
            let b = neighbour(at, -off);
            if a == NONE || b == NONE {
                continue;
            }
            let pair = Sum(fraction_at(a) + fraction_at(b), noise_at(a) + noise_at(b), 2.0);
            if !agree(sum, pair) {
                closed |= 1u << direction;
                continue;
            }
            varies |= fraction_at(a) != own || fraction_at(b) != own;
            ring = Sum(ring.fractions + pair.fractions, ring.variances + pair.variances, ring.count + pair.count);
            pairs |= 1u << (4u * stride + direction);
        }
        sum = Sum(sum.fractions + ring.fractions, sum.variances + ring.variances, sum.count + ring.count);
        // Most samples are in full light or in umbra, as their neighbours are.
        if !varies && ring.count > 0.0 {
            break;
        }
    }
    return Smoothed(sum, varies, pairs);
}

// Pixel at an offset, if it has a fraction and lies on the same surface; else NONE.
fn neighbour(at: vec2<u32>, off: vec2<i32>) -> u32 {
    let there = vec2<i32>(at) + off;
    if any(there < vec2(0)) || any(there >= vec2<i32>(vec2(frame.width, frame.height))) {
        return NONE;
    }
    let other = pixel_of(vec2<u32>(there));
    let distance = u32(max(abs(off.x), abs(off.y)));
    return select(NONE, other, fraction_at(other) >= 0.0 && !is_discontinuity(pixel_of(at), other, distance));
}

// Expected squared error of a fraction, where masks whose samples all agree are uncertain as well.
fn noise_at(pixel: u32) -> f32 {
    let agreed = AGREED / f32(frame.pattern.count);
    return max(variance_at(pixel), agreed * agreed);
}

// True if a pair differs from the mean no more than noise explains.
fn agree(sum: Sum, pair: Sum) -> bool {
    let difference = pair.fractions / pair.count - sum.fractions / sum.count;
    let variance = (sum.variances + pair.variances) / (sum.count + pair.count);
    let most = select(FROM_ONE, FROM_SEVERAL, sum.count > 1.0);
    return difference * difference <= most * most * variance * (1.0 / pair.count + 1.0 / sum.count);
}
