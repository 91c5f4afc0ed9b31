// Imports a caller's G-buffer, per pixel: from points or depths, and normals, to receivers.
//@ needs shared/offset
//@ reads given_point given_normal
//@ writes position normal

// True if depths are given instead of points.
override DEPTH: bool = false;

@compute @workgroup_size(8, 8)
fn take(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= frame.width || at.y >= frame.height {
        return;
    }
    let pixel = at.y * frame.width + at.x;
    let given = textureLoad(given_point, at.xy, 0);
    let up = textureLoad(given_normal, at.xy, 0).xyz;
    if all(up == vec3(0.0)) {
        position[pixel] = vec4(0.0, 0.0, 0.0, -1.0);
        normal[pixel] = vec4(0u, 0u, 0u, NONE);
        return;
    }
    let d = frame.corner + frame.right * (f32(at.x) + 0.5) + frame.down * (f32(at.y) + 0.5);
    let point = select(given.xyz, frame.eye + d * given.x, DEPTH);
    let depth = select(dot3(given.xyz - frame.eye, forward()), given.x, DEPTH);
    position[pixel] = vec4(point + up * offset_at(point, depth), depth);
    // Triangles are unknown: every pixel gets a surface of its own, and surfaces are compared by position.
    normal[pixel] = vec4(bitcast<vec3<u32>>(up), pixel);
}
