// Adds the sums of all tiles to a counter that holds a float, once per light. One workgroup sums in a fixed
// order.
//@ needs shared/counters
//@ reads tile_sums

override COUNTER: u32 = EXPECTED;

var<workgroup> parts: array<f32, 64>;

@compute @workgroup_size(64)
fn sum(@builtin(local_invocation_index) lane: u32) {
    let tiles = (vec2(frame.width, frame.height) + 7u) / 8u;
    var part = 0.0;
    for (var tile = lane; tile < tiles.x * tiles.y; tile += 64u) {
        part += tile_sums[tile];
    }
    parts[lane] = part;
    workgroupBarrier();
    if lane > 0u {
        return;
    }
    var all = bitcast<f32>(atomicLoad(&counters[COUNTER]));
    for (var other = 0u; other < 64u; other++) {
        all += parts[other];
    }
    atomicStore(&counters[COUNTER], bitcast<u32>(all));
}
