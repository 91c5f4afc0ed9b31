// Noise of a mask of a textured light, per query (halflight-cpu/src/refine/target.rs). Light samples of error targets
// have fewer than 32 columns.
//@ needs shared/noise_estimate textured/strata
//@ reads wanted visible

fn query_noise(query: u32) -> Noise {
    let first = query * frame.pattern.words;
    let strata = strata_first();
    let columns = frame.pattern.columns;
    var lit = 0u;
    var count = 0u;
    // Number of neighbours in a row or in a column, and number of those that differ.
    var pairs = 0u;
    var differ = 0u;
    // Half the mean squares of the strata that differ, and the light of all.
    var squares = 0.0;
    var whole = vec3(0.0);
    for (var index = 0u; index < frame.pattern.count; index++) {
        if !is_wanted(first, index) {
            continue;
        }
        let sees = is_visible(first, index);
        count++;
        lit += u32(sees);
        whole += emitted[strata + index].xyz;
        for (var down = 0u; down < 2u; down++) {
            let other = index + select(1u, columns, down == 1u);
            let last = down == 0u && (index + 1u) % columns == 0u;
            if last || other >= frame.pattern.count || !is_wanted(first, other) {
                continue;
            }
            pairs++;
            if is_visible(first, other) != sees {
                differ++;
                squares += 0.5 * (emitted[strata + index].w + emitted[strata + other].w);
            }
        }
    }
    return noise_of(Neighbours(lit, count, pairs, differ), squares, dot3(whole, whole));
}

fn is_wanted(first: u32, index: u32) -> bool {
    return ((wanted[first + index / 32u] >> (index & 31u)) & 1u) != 0u;
}

fn is_visible(first: u32, index: u32) -> bool {
    return ((visible[first + index / 32u] >> (index & 31u)) & 1u) != 0u;
}
