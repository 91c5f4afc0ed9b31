// Adds a light that the camera sees, per pixel: from the ray of the pixel's centre to the radiance and the distance of the nearest
// light before the surface (halflight-cpu/src/emission.rs).
//@ needs shared/light
//@ reads position
//@ writes emission

@compute @workgroup_size(8, 8)
fn see(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= frame.width || at.y >= frame.height || all(facing(frame.eye) == vec3(0.0)) {
        return;
    }
    let pixel = at.y * frame.width + at.x;
    let d = frame.corner + frame.right * (f32(at.x) + 0.5) + frame.down * (f32(at.y) + 0.5);
    let height = -dot3(frame.light_normal, from_light(frame.eye));
    let along = dot3(frame.light_normal, d);
    // The ray points away from the light's plane, or along it.
    if height * along <= 0.0 {
        return;
    }
    let t = height / along;
    let point = from_light(frame.eye) + d * t;
    let dual = light_dual();
    let place = vec2(dot3(point, dual.u), dot3(point, dual.v));
    if !(all(place >= vec2(0.0)) && all(place <= vec2(1.0)) && light_contains(place)) {
        return;
    }
    let depth = position[pixel].w;
    let nearest = emission[pixel].w;
    // Below 0 there is no surface; 0 stands for no light.
    if (depth < 0.0 || t < depth) && (nearest == 0.0 || t < nearest) {
        emission[pixel] = vec4(frame.radiance, t);
    }
}
