// What errors are held against: the image's square, by luminance.
//@ needs shared/tiles
//@ reads image

@compute @workgroup_size(8, 8)
fn measure(
    @builtin(global_invocation_id) at: vec3<u32>,
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    var bright = 0.0;
    if at.x < frame.width && at.y < frame.height {
        bright = luminance(image[at.y * frame.width + at.x].xyz);
    }
    add_up(lane, workgroup, bright * bright);
}
