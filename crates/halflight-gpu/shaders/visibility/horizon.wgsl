// Which rays are worth it.
//@ needs shared/light shared/receiver

// Whether a sample lies above both horizons. Between the corners all of the light is above the receiver's if they are.
fn adds_light(receiver: Receiver, end: vec3<f32>) -> bool {
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
