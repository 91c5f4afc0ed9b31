// Where shadow rays start. `position` holds points and depths (below 0 where nothing is seen).
//@ needs shared/surface
//@ reads position

struct Receiver {
    // Moved off the surface.
    origin: vec3<f32>,
    normal: vec3<f32>,
}

// Eight units in the last place of single precision at 1.
const ROUNDING: f32 = 9.5367431640625e-7;

fn rounding_at(point: vec3<f32>) -> f32 {
    let size = abs(point);
    return max(max(size.x, size.y), size.z) * ROUNDING;
}

fn receiver_at(pixel: u32) -> Receiver {
    let point = position[pixel].xyz;
    let up = normal_at(pixel);
    return Receiver(point + up * max(rounding_at(point), frame.scene_size * 3e-5), up);
}
