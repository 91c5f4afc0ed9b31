// Computes values of kept cells, per cell: from the masks of all its queries to irradiance or the visible
// fraction.
//@ needs shared/counters shared/sums
//@ writes samples

// Interpolated quantity: 0 irradiance, 1 the visible fraction.
override SHADING: u32 = 1u;

@compute @workgroup_size(64)
fn value(here: Lane) {
    let first = invocation(here) * frame.slots;
    if first >= atomicLoad(&counters[END]) {
        return;
    }
    let place = queries[first].place;
    if place == NONE {
        return;
    }
    var all = Sums(0.0, 0.0, 0u);
    for (var part = 0u; part < frame.slots; part++) {
        let sums = query_sums(first + part);
        all = Sums(all.visible + sums.visible, all.all + sums.all, all.count + sums.count);
    }
    if SHADING == 0u {
        samples[place].value = sums_sampled(all);
    } else {
        samples[place].value = sums_fraction(all);
    }
}
