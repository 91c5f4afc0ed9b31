// Reduces the depths of receivers and triangles, per pixel and per triangle corner: to the depth range of the
// voxels.
//@ needs shared/surface visibility/voxel_space
//@ reads position triangles
//@ writes voxels

// Bits of infinity; negative numbers and NaN have larger bits.
const INFINITE: u32 = 0x7f800000u;

var<workgroup> nearest: atomic<u32>;
var<workgroup> farthest: atomic<u32>;
var<workgroup> deepest: atomic<u32>;

@compute @workgroup_size(64)
fn find_range(here: Lane) {
    let index = invocation(here);
    if index < frame.width * frame.height && is_receiver(index) {
        // Floats that are neither negative nor infinite are ordered as their bits.
        let depth = bitcast<u32>(position[index].w);
        if depth < INFINITE {
            atomicMax(&nearest, ~depth);
            atomicMax(&farthest, depth);
        }
    }
    // Whole triangles: something is bound where there are none.
    if index < arrayLength(&triangles) / 3u * 3u {
        atomicMax(&deepest, bitcast<u32>(max(dot3(space.forward, triangles[index].xyz - frame.eye), 0.0)));
    }
    workgroupBarrier();
    if here.index == 0u {
        atomicMax(&voxels[NEAR], atomicLoad(&nearest));
        atomicMax(&voxels[FAR], atomicLoad(&farthest));
        atomicMax(&voxels[DEEPEST], atomicLoad(&deepest));
    }
}
