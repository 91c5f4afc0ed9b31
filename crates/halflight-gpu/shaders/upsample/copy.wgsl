// Pixels that all have samples of their own: every upsampler leaves them as they are.
//@ needs shared/query shared/surface
//@ reads samples
//@ writes plane

@compute @workgroup_size(8, 8)
fn copy(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= frame.width || at.y >= frame.height {
        return;
    }
    let pixel = at.y * frame.width + at.x;
    // Where no value exists the light is below the horizon, and so is all that is multiplied with it.
    plane[pixel] = select(0.0, max(samples[pixel].value, 0.0), is_receiver(pixel));
}
