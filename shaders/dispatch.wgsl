// Sizes of the dispatches that depend on how many queries there are.

// Workgroups along one side at most.
const SIDE: u32 = 65535u;

@compute @workgroup_size(1)
fn dispatch() {
    let count = min(atomicLoad(&counters[QUERIES]), frame.capacity);
    // A ray each, and a query each.
    let stride = frame.pattern.stride;
    let rays = select((count * stride + 63u) / 64u, count * (stride / 64u), stride > 64u);
    set_size(0u, rays);
    set_size(1u, (count + 63u) / 64u);
    atomicAdd(&counters[PER_LEVEL + frame.level], count);
}

fn set_size(slot: u32, groups: u32) {
    arguments[3u * slot] = min(groups, SIDE);
    arguments[3u * slot + 1u] = (groups + SIDE - 1u) / SIDE;
    arguments[3u * slot + 2u] = 1u;
}
