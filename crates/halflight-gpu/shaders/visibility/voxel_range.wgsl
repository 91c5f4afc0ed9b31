// Depths of receivers and triangles, between which the voxels will lie.
//@ needs shared/surface visibility/voxel_space
//@ reads position triangles
//@ writes voxels

// Bits of infinity; those of what is negative or no number are more.
const INFINITE: u32 = 0x7f800000u;

var<workgroup> nearest: atomic<u32>;
var<workgroup> farthest: atomic<u32>;
var<workgroup> deepest: atomic<u32>;

@compute @workgroup_size(64)
fn find_range(here: Lane) {
    let index = invocation(here);
    if index < frame.width * frame.height && is_receiver(index) {
        // Floats that are neither negative nor infinite have the order of their bits.
        let depth = bitcast<u32>(position[index].w);
        if depth < INFINITE {
            atomicMax(&nearest, ~depth);
            atomicMax(&farthest, depth);
        }
    }
    if index < 3u * TRIANGLES {
        atomicMax(&deepest, bitcast<u32>(max(dot3(space.forward, triangles[index].xyz - frame.eye), 0.0)));
    }
    workgroupBarrier();
    if here.index == 0u {
        atomicMax(&voxels[NEAR], atomicLoad(&nearest));
        atomicMax(&voxels[FAR], atomicLoad(&farthest));
        atomicMax(&voxels[DEEPEST], atomicLoad(&deepest));
    }
}
