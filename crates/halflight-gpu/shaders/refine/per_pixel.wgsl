// Requests a complete mask, per pixel: from the G-buffer to queries. Tiles of 8 × 8 pixels, whose receivers
// see almost the same geometry, stay together.
//@ needs shared/append shared/query_mask shared/surface
//@ writes samples owners

@compute @workgroup_size(8, 8)
fn request(here: Tile) {
    let pixel = here.at.y * frame.width + here.at.x;
    var asks = here.at.x < frame.width && here.at.y < frame.height;
    if asks {
        asks = is_receiver(pixel);
        samples[pixel] = Sample(vec2<f32>(here.at.xy) + 0.5, NO_VALUE, pixel);
        owners[pixel] = select(NONE, 0u, asks);
    }
    let slot = append(here.lane, asks, QUERIES, frame.capacity);
    if here.lane == 0u {
        let bucket = pixel_bucket(here.workgroup);
        atomicAdd(&counters[bucket], appended());
        // One cell per sample.
        atomicAdd(&counters[bucket + (CELLS_PER_LEVEL - SAMPLES_PER_LEVEL) * BUCKETS], appended());
    }
    if slot == NONE {
        return;
    }
    ask_all(slot, pixel);
}
