// Sizes of dispatches that the device finds.
//@ writes arguments

// Workgroups along one side at most.
const SIDE: u32 = 65535u;

fn set_size(slot: u32, groups: u32) {
    arguments[3u * slot] = min(groups, SIDE);
    arguments[3u * slot + 1u] = (groups + SIDE - 1u) / SIDE;
    arguments[3u * slot + 2u] = 1u;
}
