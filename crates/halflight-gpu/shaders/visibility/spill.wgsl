// Computes indirect dispatch arguments, once per batch: for the rays of queries that another backend left to
// them.
//@ needs shared/arguments
//@ writes spilled

@compute @workgroup_size(1)
fn spill() {
    let count = atomicLoad(&spilled[0]);
    set_size(4u, ray_groups(count));
}
