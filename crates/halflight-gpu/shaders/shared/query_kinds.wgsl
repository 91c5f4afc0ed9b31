// Kinds of samples in the mask of a query.
//@ reads wanted visible

// True first if a wanted sample is visible, and second if one is not.
fn lit_and_unlit(query: u32) -> vec2<bool> {
    let first = query * frame.pattern.words;
    var lit = 0u;
    var unlit = 0u;
    for (var word = first; word < first + frame.pattern.words; word++) {
        lit |= wanted[word] & visible[word];
        unlit |= wanted[word] & ~visible[word];
    }
    return vec2(lit != 0u, unlit != 0u);
}
