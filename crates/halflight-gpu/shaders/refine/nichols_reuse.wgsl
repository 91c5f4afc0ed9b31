// Reuses visibility bits on which the coarser neighbourhood agrees (Nichols10 §3.3.2), per query of the
// level: from coarser masks to reused bits and the samples left to trace.
//@ needs shared/query_batch shared/query shared/votes
//@ reads queries
//@ writes wanted reused

@compute @workgroup_size(64)
fn reuse(here: Lane) {
    let query = query_of(invocation(here));
    if query == NONE {
        return;
    }
    let cell = cell_of(queries[query].place - level_first(frame.level));
    // A cell whose parent was not rendered has masks of its parent's neighbours only, which may lie on other
    // surfaces.
    var known_there = false;
    if frame.level < frame.coarsest {
        known_there = cells[cell_index(frame.level + 1u, cell / 2u)].state == RENDERED;
    }
    for (var word = 0u; word < frame.pattern.words; word++) {
        let at = query * frame.pattern.words + word;
        var known = vec2(0u);
        if known_there {
            let votes = votes_around(frame.level + 1u, cell / 2u, word);
            let agreed = (votes.lit ^ votes.unlit) & wanted[at];
            known = vec2(agreed, votes.lit & agreed);
            wanted[at] &= ~agreed;
        }
        reused[at] = known;
    }
}
