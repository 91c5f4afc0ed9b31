// Rays from receivers to points of the light, in any position on it.
//@ needs shared/receiver visibility/bvh

fn is_hidden(receiver: Receiver, at: vec2<f32>, end: vec3<f32>) -> bool {
    return occluded(receiver.origin, end);
}
