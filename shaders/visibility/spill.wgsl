// Size of the dispatch of rays for queries that were left to them.
//@ needs shared/arguments
//@ writes spilled

@compute @workgroup_size(1)
fn spill() {
    let count = atomicLoad(&spilled[0]);
    let stride = frame.pattern.stride;
    set_size(4u, select((count * stride + 63u) / 64u, count * (stride / 64u), stride > 64u));
}
