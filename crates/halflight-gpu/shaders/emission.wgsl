// Adds a light that the camera sees, per pixel: from the ray of the pixel's centre to the radiance and the distance of the nearest
// light before the surface (halflight-cpu/src/emission.rs). `emission_at` is that of a uniform or of a textured light.
//@ needs shared/light shared/surface
//@ reads position
//@ writes emission

@compute @workgroup_size(8, 8)
fn see(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= frame.width || at.y >= frame.height {
        return;
    }
    let pixel = at.y * frame.width + at.x;
    let d = frame.corner + frame.right * (f32(at.x) + 0.5) + frame.down * (f32(at.y) + 0.5);
    // Parameter where the ray meets the light, 0 where it does not, and the place there.
    var t = 0.0;
    var place = vec2(0.0);
    if is_sphere() {
        t = sphere_along(d);
    } else if any(facing(frame.eye) != vec3(0.0)) {
        t = plane_along(d);
        let dual = light_dual();
        let point = from_light(frame.eye) + d * t;
        place = vec2(dot3(point, dual.u), dot3(point, dual.v));
        if !(all(place >= vec2(0.0)) && all(place <= vec2(1.0)) && light_contains(place)) {
            t = 0.0;
        }
    }
    if t <= 0.0 {
        return;
    }
    let nearest = emission[pixel].w;
    // 0 stands for no light.
    if !hidden(pixel, d * t) && (nearest == 0.0 || t < nearest) {
        emission[pixel] = vec4(emission_at(place), t);
    }
}

// Height below a surface, relative to the largest coordinate, from which on a light is behind it: more than the CPU's, since points have been moved off their
// surfaces.
const BEHIND: f32 = 32.0 / 16777216.0;

// True if the surface of a pixel hides a point, relative to the eye. Without a surface the depth is below 0.
fn hidden(pixel: u32, at: vec3<f32>) -> bool {
    let point = position[pixel];
    let sizes = max(max(abs(point.xyz), abs(frame.eye)), abs(point.xyz - frame.eye));
    let slack = BEHIND * max(max(sizes.x, sizes.y), sizes.z);
    return point.w >= 0.0 && dot3(normal_at(pixel), at - (point.xyz - frame.eye)) < -slack;
}

// Parameter where a ray along `d` from the eye meets the plane of a flat light; 0 where it points away from it, or along it.
fn plane_along(d: vec3<f32>) -> f32 {
    let height = -dot3(frame.light_normal, from_light(frame.eye));
    let along = dot3(frame.light_normal, d);
    return select(0.0, height / along, height * along > 0.0);
}

// Parameter of the nearest point of a sphere, from inside of the only one; 0 beside it.
fn sphere_along(d: vec3<f32>) -> f32 {
    let centre = sphere().xyz - frame.eye;
    let far = length3(centre);
    // Square of the eye's distance from the centre without that of the radius.
    let outside = (far - sphere().w) * (far + sphere().w);
    let square = dot3(d, d);
    let along = dot3(centre, d);
    let under = along * along - square * outside;
    if under < 0.0 {
        return 0.0;
    }
    let root = sqrt(under);
    if outside > 0.0 {
        return select(0.0, outside / (along + root), along > 0.0);
    }
    return (along + root) / square;
}
