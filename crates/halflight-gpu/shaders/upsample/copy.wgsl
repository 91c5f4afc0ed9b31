// Copies sample values to pixels, per pixel, where every pixel has a sample: all upsamplers keep these
// values.
//@ needs shared/query shared/surface
//@ reads samples
//@ writes plane

@compute @workgroup_size(8, 8)
fn copy(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= frame.width || at.y >= frame.height {
        return;
    }
    let pixel = at.y * frame.width + at.x;
    // An undefined value means that the light is below the horizon: the pixel is 0.
    plane[pixel] = select(0.0, max(samples[pixel].value, 0.0), is_receiver(pixel));
}
