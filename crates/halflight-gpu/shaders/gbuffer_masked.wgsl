// Rasterizes indices of triangles with alpha masks, per pixel: where the pixel's centre sees a solid texel.
//@ needs gbuffer shared/solid

@fragment
fn solid_fragment(
    @builtin(position) at: vec4<f32>,
    @location(0) @interpolate(flat) triangle: u32,
) -> @location(0) u32 {
    let d = frame.corner + frame.right * at.x + frame.down * at.y;
    if !is_solid(triangle, frame.eye, d) {
        discard;
    }
    return triangle;
}
