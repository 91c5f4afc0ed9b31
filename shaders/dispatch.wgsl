// Sizes of the dispatches that depend on how many cells have asked.
//@ needs shared/arguments shared/counters

@compute @workgroup_size(1)
fn dispatch() {
    let first = atomicLoad(&counters[END]);
    let end = min(atomicLoad(&counters[QUERIES]) * frame.slots, frame.capacity);
    atomicStore(&counters[FIRST], first);
    atomicStore(&counters[END], end);
    let count = end - first;
    // An invocation each for rays, queries, cells, and all queries so far.
    let stride = frame.pattern.stride;
    set_size(0u, select((count * stride + 63u) / 64u, count * (stride / 64u), stride > 64u));
    set_size(1u, (count + 63u) / 64u);
    set_size(2u, (count / frame.slots + 63u) / 64u);
    set_size(3u, (end + 63u) / 64u);
}
