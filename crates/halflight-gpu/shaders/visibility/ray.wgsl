// Rays from receivers to points of the light, in any position on it.
//@ needs shared/light shared/receiver visibility/bvh

fn is_hidden(receiver: Receiver, at: vec2<f32>, end: vec3<f32>) -> bool {
    if is_sphere() {
        let stop = before_sphere(receiver.origin, end);
        return any(stop != receiver.origin) && occluded(receiver.origin, stop);
    }
    return occluded(receiver.origin, end);
}
