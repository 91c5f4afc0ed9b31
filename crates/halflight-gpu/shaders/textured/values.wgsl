// Values of pixels under a textured light, by channel.
//@ needs shared/receiver textured/seen
//@ reads planes

fn values_at(pixel: u32) -> vec3<f32> {
    let pixels = frame.width * frame.height;
    return vec3(planes[pixel], planes[pixels + pixel], planes[2u * pixels + pixel]);
}

// Mean factors of the radiance without occluders.
fn seen_at(receiver: Receiver) -> vec3<f32> {
    return seen(receiver.origin, receiver.normal);
}
