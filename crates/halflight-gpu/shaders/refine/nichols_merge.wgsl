// Merges reused visibility bits into traced masks, per query.
//@ needs shared/query_batch
//@ reads reused
//@ writes wanted visible

@compute @workgroup_size(64)
fn merge(here: Lane) {
    let query = query_of(invocation(here));
    if query == NONE {
        return;
    }
    for (var word = 0u; word < frame.pattern.words; word++) {
        let at = query * frame.pattern.words + word;
        visible[at] = (visible[at] & wanted[at]) | reused[at].y;
        wanted[at] |= reused[at].x;
    }
}
