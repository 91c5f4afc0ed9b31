// Gathers one level of discontinuities, per cell: from the flags of its four children to their union.
//@ writes discontinuities

@compute @workgroup_size(8, 8)
fn gather(@builtin(global_invocation_id) at: vec3<u32>) {
    if any(at.xy >= level_size(frame.level)) {
        return;
    }
    let finer = level_size(frame.level - 1u);
    var flags = 0u;
    for (var child = 0u; child < 4u; child++) {
        let cell = 2u * at.xy + vec2(child & 1u, child >> 1u);
        if all(cell < finer) {
            flags |= discontinuities[cell_index(frame.level - 1u, cell)];
        }
    }
    discontinuities[cell_index(frame.level, at.xy)] = flags;
}
