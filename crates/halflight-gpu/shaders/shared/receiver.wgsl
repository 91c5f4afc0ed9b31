// Origins of shadow rays. `position` holds them, and depths (negative for the background).
//@ needs shared/surface
//@ reads position

struct Receiver {
    // Moved off the surface.
    origin: vec3<f32>,
    // Shading normal.
    normal: vec3<f32>,
}

fn receiver_at(pixel: u32) -> Receiver {
    return Receiver(position[pixel].xyz, shading_at(pixel));
}
