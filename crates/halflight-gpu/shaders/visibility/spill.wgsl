// Size of the dispatch of rays for queries that were left to them.
//@ needs shared/arguments
//@ writes spilled

@compute @workgroup_size(1)
fn spill() {
    let count = atomicLoad(&spilled[0]);
    set_size(4u, ray_groups(count));
}
