// Computes sample values, per sample: from the masks of its queries to irradiance or the visible fraction, of a uniform or
// of a textured light (shared/value, textured/value). Covers the queries of all batches that have a destination.
//@ needs shared/counters
//@ reads queries
//@ writes samples

// Interpolated quantity: 0 irradiance, 1 the visible fraction.
override SHADING: u32 = 1u;

@compute @workgroup_size(64)
fn irradiance(here: Lane) {
    let first = invocation(here) * frame.slots;
    if first >= atomicLoad(&counters[END]) {
        return;
    }
    let place = queries[first].place;
    if place == NONE {
        return;
    }
    if SHADING == 0u {
        samples[place].value = keep_colours(place, irradiance_of_queries(first, frame.slots));
    } else if frame.slots == 1u {
        samples[place].value = keep_colours(place, query_colours(first));
    } else {
        samples[place].value = keep_colours(place, colours_of_queries(first, frame.slots));
    }
}
