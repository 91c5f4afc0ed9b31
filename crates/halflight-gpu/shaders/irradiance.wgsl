// Computes sample values, per query: from masks to irradiance or the visible fraction. For samples that
// consist of one query; covers the queries of all batches that have a destination.
//@ needs shared/counters shared/sums
//@ writes samples

// Interpolated quantity: 0 irradiance, 1 the visible fraction.
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
