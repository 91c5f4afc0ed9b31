// Computes indirect dispatch arguments, once per pass: from the number of queries appended so far.
//@ needs shared/arguments shared/counters

@compute @workgroup_size(1)
fn dispatch() {
    let first = atomicLoad(&counters[END]);
    // Cells whose queries did not all fit have none.
    let end = min(atomicLoad(&counters[QUERIES]), frame.capacity / frame.slots) * frame.slots;
    atomicStore(&counters[FIRST], first);
    atomicStore(&counters[END], end);
    let count = end - first;
    // One invocation per ray, per query, per cell, and per query of all batches so far.
    set_size(0u, ray_groups(count));
    set_size(1u, (count + 63u) / 64u);
    set_size(2u, (count / frame.slots + 63u) / 64u);
    set_size(3u, (end + 63u) / 64u);
}
