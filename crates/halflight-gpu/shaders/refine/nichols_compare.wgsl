// Flags illumination discontinuities, per query: from the masks in a rendered cell's neighbourhood to its
// flag.
//@ needs shared/query_batch shared/query shared/votes
//@ reads queries
//@ writes cells

@compute @workgroup_size(64)
fn compare(here: Lane) {
    let query = query_of(invocation(here));
    if query == NONE {
        return;
    }
    let index = queries[query].place;
    let cell = cell_of(index - level_first(frame.level));
    var changed = 0u;
    for (var word = 0u; word < frame.pattern.words; word++) {
        let votes = votes_around(frame.level, cell, word);
        changed += countOneBits(votes.lit & votes.unlit & wanted[query * frame.pattern.words + word]);
    }
    cells[index].flag = u32(f32(changed) >= frame.enough);
}
