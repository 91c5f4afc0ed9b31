// Computes indirect dispatch arguments, once per frame: for large triangles.
//@ needs shared/arguments visibility/voxel_size
//@ writes large

@compute @workgroup_size(1)
fn size_large() {
    set_size(5u, atomicLoad(&large[0]) * bands());
}
