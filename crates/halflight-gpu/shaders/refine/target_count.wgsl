// Counts pending cells of a level and all receivers, per cell: reduced by workgroup into two counters.
//@ needs shared/cells shared/counters shared/surface

var<workgroup> open: atomic<u32>;
var<workgroup> receivers: atomic<u32>;

@compute @workgroup_size(8, 8)
fn count(@builtin(global_invocation_id) at: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    if all(at.xy < level_size(frame.level)) {
        let first = at.xy << vec2(frame.level);
        let last = min(first + (1u << frame.level), vec2(frame.width, frame.height));
        var found = 0u;
        for (var y = first.y; y < last.y; y++) {
            for (var x = first.x; x < last.x; x++) {
                found += u32(is_receiver(y * frame.width + x));
            }
        }
        atomicAdd(&receivers, found);
        atomicAdd(&open, u32(cells[cell_index(frame.level, at.xy)].state == PENDING));
    }
    workgroupBarrier();
    if lane == 0u {
        atomicAdd(&counters[CELLS_LEFT], atomicLoad(&open));
        atomicAdd(&counters[PIXELS_SEEN], atomicLoad(&receivers));
    }
}
