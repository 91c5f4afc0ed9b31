// What the receivers of a trial show: how bright they are, and how noisy (halflight-cpu/src/refine/target.rs).
//@ needs shared/at_hand shared/sums shared/unshadowed
//@ writes samples

// Expected squared error over the share of neighbouring samples that differ, as on the CPU.
const NOISE: f32 = 0.12;

// All samples of 8 × 8 but those in the last column.
const INNER: u32 = 0x7f7f7f7fu;

@compute @workgroup_size(64)
fn show(here: Lane) {
    let query = query_of(invocation(here));
    if query == NONE {
        return;
    }
    let pixel = queries[query].pixel;
    let receiver = receiver_at(pixel);
    let bright = unshadowed(receiver.origin, receiver.normal);
    let seen = bright * max(query_fraction(query), 0.0);
    let asked = vec2(wanted[2u * query], wanted[2u * query + 1u]);
    let lit = vec2(visible[2u * query], visible[2u * query + 1u]);
    let count = sum_of(countOneBits(asked));
    // Neighbours in a row and in a column, and those of them that differ.
    let across = asked & right_of(asked) & vec2(INNER);
    let down = asked & below(asked);
    let pairs = sum_of(countOneBits(across)) + sum_of(countOneBits(down));
    let differ = sum_of(countOneBits(across & (lit ^ right_of(lit)))) + sum_of(countOneBits(down & (lit ^ below(lit))));
    let plain = all((asked & lit) == vec2(0u)) || all((asked & ~lit) == vec2(0u));
    let variance = select(NOISE * f32(differ) / f32(max(count * count, 1u)), 0.0, plain);
    samples[pixel] = Sample(vec2(seen * seen, bright * bright * variance), f32(differ) / f32(max(pairs, 1u)), pixel);
}

fn sum_of(counts: vec2<u32>) -> u32 {
    return counts.x + counts.y;
}

// The samples one to the right; what the last column has is left out by INNER.
fn right_of(mask: vec2<u32>) -> vec2<u32> {
    return mask >> vec2(1u);
}

fn below(mask: vec2<u32>) -> vec2<u32> {
    return vec2((mask.x >> 8u) | (mask.y << 24u), mask.y >> 8u);
}
