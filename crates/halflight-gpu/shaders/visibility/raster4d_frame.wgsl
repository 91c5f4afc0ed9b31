// Reduces the bounds of the framebuffer, per pixel: from receivers projected through the light's corner to
// their extremes.
//@ needs shared/receiver shared/sortable visibility/raster4d
//@ writes bins

var<workgroup> ends: array<atomic<u32>, 8>;

@compute @workgroup_size(64)
fn lay_out(here: Lane) {
    let pixel = invocation(here);
    if pixel < frame.width * frame.height && is_receiver(pixel) {
        let origin = receiver_at(pixel).origin;
        let side = side_of(origin);
        let p = local(origin, side);
        if side < frame.sides && is_projected(p) {
            let place = squeezed(slope(p, 0.0));
            atomicMax(&ends[4u * side], ~sortable(place.x));
            atomicMax(&ends[4u * side + 1u], ~sortable(place.y));
            atomicMax(&ends[4u * side + 2u], sortable(place.x));
            atomicMax(&ends[4u * side + 3u], sortable(place.y));
        }
    }
    workgroupBarrier();
    if here.index < 8u {
        atomicMax(&bins[here.index], atomicLoad(&ends[here.index]));
    }
}
