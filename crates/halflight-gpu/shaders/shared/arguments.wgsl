// Indirect dispatch arguments that the GPU computes.
//@ writes arguments

// Most workgroups along one dimension.
const SIDE: u32 = 65535u;

fn set_size(slot: u32, groups: u32) {
    arguments[3u * slot] = min(groups, SIDE);
    arguments[3u * slot + 1u] = groups / SIDE + u32(groups % SIDE > 0u);
    arguments[3u * slot + 2u] = 1u;
}

// Number of workgroups for the rays of queries. The number of rays may take more than 32 bits.
fn ray_groups(queries: u32) -> u32 {
    let stride = frame.pattern.stride;
    if stride > 64u {
        return queries * (stride / 64u);
    }
    let together = 64u / stride;
    return (queries + together - 1u) / together;
}
