// How far rays to a light end before its plane: a voxel's width, so that what it is mounted on does not stop them.
//@ needs shared/light visibility/voxel_space
//@ writes voxels

@compute @workgroup_size(1)
fn find_clearance() {
    let range = depth_range(atomicLoad(&voxels[NEAR]), atomicLoad(&voxels[FAR]), atomicLoad(&voxels[DEEPEST]));
    var corners = light_corners();
    let middle = (corners[0] + corners[2]) * 0.5;
    var points = array(corners[0], corners[1], corners[2], corners[3], middle);
    var width = 0.0;
    for (var point = 0u; point < 5u; point++) {
        if range.x < range.y && holds(place(points[point]), range) {
            width = max(width, width_along(points[point], frame.light_normal, range));
        }
    }
    atomicStore(&voxels[LIGHTS + frame.light], bitcast<u32>(width * BIAS));
}

// True if a position lies in the grid, borders included.
fn holds(p: vec3<f32>, range: vec2<f32>) -> bool {
    let widest = f32(RESOLUTION) * p.z;
    return p.z >= range.x && p.z <= range.y && p.x >= 0.0 && p.x <= widest && p.y >= 0.0 && p.y <= widest;
}
