// Smooths visible fractions, per pixel with a mask: from fractions and their noise to samples, and to the noise that is left in `plane`
// (halflight-cpu/src/refine/lattice/denoise.rs).
//@ needs shared/smoothing
//@ writes samples plane

@compute @workgroup_size(8, 8)
fn smooth_fractions(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= frame.width || at.y >= frame.height {
        return;
    }
    let pixel = pixel_of(at.xy);
    if fraction_at(pixel) < 0.0 {
        plane[pixel] = 0.0;
        return;
    }
    let found = smoothed(at.xy);
    let sum = found.sum;
    if found.varies {
        samples[pixel].value = sum.fractions / sum.count;
        plane[pixel] = sum.variances / (sum.count * sum.count);
    } else {
        plane[pixel] = 0.0;
    }
}
