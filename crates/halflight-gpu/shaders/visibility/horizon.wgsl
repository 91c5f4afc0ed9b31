// Horizon culling, per ray, and that of samples beside a light that is no parallelogram.
//@ needs shared/light shared/receiver

// True if a sample is the light's and lies above both horizons. If all corners of the light are above the receiver's horizon,
// all of the light is.
fn adds_light(receiver: Receiver, place: vec2<f32>, end: vec3<f32>) -> bool {
    if frame.outline.x != PARALLELOGRAM && !light_contains(place) {
        return false;
    }
    let towards = facing(receiver.origin);
    if all(towards == vec3(0.0)) {
        return false;
    }
    let above = corners_above(receiver.origin, receiver.normal);
    if above == 0u || above == 4u {
        return above == 4u;
    }
    return geometry_term(end - receiver.origin, receiver.normal, towards) > 0.0;
}
