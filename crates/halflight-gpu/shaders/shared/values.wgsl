// Values of pixels under a uniform light, the same for red, green and blue.
//@ needs shared/receiver
//@ reads plane

fn values_at(pixel: u32) -> vec3<f32> {
    return vec3(plane[pixel]);
}

// Mean factors of the radiance without occluders.
fn seen_at(receiver: Receiver) -> vec3<f32> {
    return vec3(1.0);
}
