// Noise of a mask, per query (halflight-cpu/src/refine/target.rs). Light samples of error targets have fewer
// than 32 columns.
//@ needs shared/noise_estimate
//@ reads wanted visible

fn query_noise(query: u32) -> Noise {
    let first = query * frame.pattern.words;
    let columns = frame.pattern.columns;
    var lit = 0u;
    var count = 0u;
    // Number of neighbours in a row or in a column, and number of those that differ.
    var pairs = 0u;
    var differ = 0u;
    // Offset of the next sample in the last column, from the word's first bit on.
    var edge = columns - 1u;
    for (var word = 0u; word < frame.pattern.words; word++) {
        let place = first + word;
        var inner = NONE;
        while edge < 32u {
            inner &= ~(1u << edge);
            edge += columns;
        }
        edge -= 32u;
        let asked = wanted[place];
        let seen = visible[place];
        var asked_next = 0u;
        var seen_next = 0u;
        if word + 1u < frame.pattern.words {
            asked_next = wanted[place + 1u];
            seen_next = visible[place + 1u];
        }
        let across = asked & later(asked, asked_next, 1u) & inner;
        let down = asked & later(asked, asked_next, columns);
        pairs += countOneBits(across) + countOneBits(down);
        differ += countOneBits(across & (seen ^ later(seen, seen_next, 1u)))
            + countOneBits(down & (seen ^ later(seen, seen_next, columns)));
        lit += countOneBits(asked & seen);
        count += countOneBits(asked);
    }
    return noise_of(Neighbours(lit, count, pairs, differ), f32(differ), f32(count * count));
}

// Bits shifted down by `by`, from 1 to 31, filled from the next word.
fn later(word: u32, next: u32, by: u32) -> u32 {
    return (word >> by) | (next << (32u - by));
}
