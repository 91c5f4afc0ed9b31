// Values of samples that are made of one query each: of all queries so far that say where theirs goes.
//@ needs shared/counters shared/sums
//@ writes samples

// What is interpolated: 0 irradiance, 1 the visible fraction.
override SHADING: u32 = 1u;

@compute @workgroup_size(64)
fn irradiance(here: Lane) {
    let query = invocation(here);
    if query >= atomicLoad(&counters[END]) {
        return;
    }
    let place = queries[query].place;
    if place == NONE {
        return;
    }
    if SHADING == 0u {
        samples[place].value = sums_sampled(query_sums(query));
    } else {
        samples[place].value = query_fraction(query);
    }
}
