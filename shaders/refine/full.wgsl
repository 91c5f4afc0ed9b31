// Every receiver asks for a full mask. Tiles of 8 × 8 pixels, whose receivers see nearly the same, stay together.
//@ needs shared/append shared/query_mask shared/surface
//@ writes samples owners

@compute @workgroup_size(8, 8)
fn full(
    @builtin(global_invocation_id) at: vec3<u32>,
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let pixel = at.y * frame.width + at.x;
    var asks = at.x < frame.width && at.y < frame.height;
    if asks {
        asks = is_receiver(pixel);
        samples[pixel] = Sample(vec2<f32>(at.xy) + 0.5, NO_VALUE, pixel);
        owners[pixel] = select(NONE, 0u, asks);
    }
    let slot = append(lane, asks, QUERIES, frame.capacity);
    if lane == 0u {
        atomicAdd(&counters[pixel_bucket(workgroup)], appended());
    }
    if slot == NONE {
        return;
    }
    ask_all(slot, pixel);
}
