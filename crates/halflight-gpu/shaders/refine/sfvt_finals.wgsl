// Requests complete masks of single pixels, per pixel in tiles of 8 × 8: level-0 cells, and additional
// samples of larger ones.
//@ needs shared/append shared/cells shared/representative shared/query_mask
//@ writes samples cells

@compute @workgroup_size(8, 8)
fn finals(@builtin(global_invocation_id) at: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let pixel = at.y * frame.width + at.x;
    var asks = false;
    if at.x < frame.width && at.y < frame.height {
        let state = cells[pixel].state;
        asks = is_receiver(pixel) && (state == PENDING || state == ADDITIONAL);
        if asks && state == PENDING {
            cells[pixel].kept = KEPT;
            asks = !faces_away(pixel);
        }
        samples[pixel] = unlit(pixel);
    }
    let slot = append(lane, asks, QUERIES, frame.capacity);
    if slot == NONE {
        return;
    }
    ask_all(slot, pixel);
}
