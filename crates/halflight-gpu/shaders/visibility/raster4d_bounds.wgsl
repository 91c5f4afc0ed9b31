// Bounds of the slopes on one side of the light, from the reduction by raster4d_frame.wgsl.
//@ needs shared/sortable visibility/raster4d
//@ writes bins

fn bounds(side: u32) -> Rectangle {
    let first = 4u * side;
    let low = vec2(sorted(~atomicLoad(&bins[first])), sorted(~atomicLoad(&bins[first + 1u])));
    let high = vec2(sorted(atomicLoad(&bins[first + 2u])), sorted(atomicLoad(&bins[first + 3u])));
    // No receiver on this side.
    if atomicLoad(&bins[first + 2u]) == 0u {
        return Rectangle(vec2(0.0), vec2(0.0));
    }
    return Rectangle(low, high);
}
