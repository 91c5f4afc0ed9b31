// Sums over tiles of 8 × 8 pixels, one workgroup each, in a fixed order.
//@ writes tile_sums

var<workgroup> tile_shares: array<f32, 64>;

// Sums `share` over the tile. All invocations of a workgroup must call this function, once.
fn add_up(here: Tile, share: f32) {
    tile_shares[here.lane] = share;
    workgroupBarrier();
    if here.lane > 0u {
        return;
    }
    var sum = 0.0;
    for (var other = 0u; other < 64u; other++) {
        sum += tile_shares[other];
    }
    tile_sums[here.workgroup.y * ((frame.width + 7u) / 8u) + here.workgroup.x] = sum;
}
