// Masks of wanted samples in queries.
//@ needs shared/hash shared/query
//@ writes queries wanted

// Word of a mask that has all samples.
fn full_word(word: u32) -> u32 {
    let left = frame.pattern.count - min(word * 32u, frame.pattern.count);
    if left >= 32u {
        return NONE;
    }
    return (1u << left) - 1u;
}

// Writes a pixel's query for all samples.
fn ask_all(slot: u32, pixel: u32) {
    queries[slot] = Query(pixel, pattern_key(pixel, pixel), frame.pattern.count, pixel);
    for (var word = 0u; word < frame.pattern.words; word++) {
        wanted[slot * frame.pattern.words + word] = full_word(word);
    }
}

// Index of the receiver, of four that share a pattern, that traces a sample: every other column of every
// other row.
fn quarter(index: u32) -> u32 {
    let column = index % frame.pattern.columns;
    let row = index / frame.pattern.columns;
    if frame.pattern.columns > 1u && frame.pattern.rows > 1u {
        return (column & 1u) | ((row & 1u) << 1u);
    }
    return index & 3u;
}

// Word of the mask of one receiver's quarter of the samples.
fn share_word(word: u32, part: u32) -> u32 {
    var mask = 0u;
    let last = min(word * 32u + 32u, frame.pattern.count);
    for (var index = word * 32u; index < last; index++) {
        if quarter(index) == part {
            mask |= 1u << (index & 31u);
        }
    }
    return mask;
}
