// Moves points onto the smooth surfaces that vertex normals imply, and writes shading normals, per pixel
// (halflight-core/src/smooth.rs).
//@ needs shared/offset shared/corner_weights shared/surface
//@ reads triangles corner_normals ids
//@ writes position normal

// Part of the distance to the planes of the vertex normals by which a point moves.
const RISE: f32 = 0.5;

@compute @workgroup_size(8, 8)
fn resolve_smooth(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= frame.width || at.y >= frame.height {
        return;
    }
    let pixel = at.y * frame.width + at.x;
    let triangle = textureLoad(ids, at.xy, 0).x;
    let flat = normal[pixel];
    normal[pixel + frame.shading] = flat;
    if triangle == NONE {
        return;
    }
    let up = normal_at(pixel);
    var normals = array(
        corner_normals[3u * triangle].xyz,
        corner_normals[3u * triangle + 1u].xyz,
        corner_normals[3u * triangle + 2u].xyz,
    );
    // Triangles are flat where they have no normals.
    if all(normals[0] == vec3(0.0)) {
        return;
    }
    let a = triangles[3u * triangle].xyz;
    let b = triangles[3u * triangle + 1u].xyz;
    let c = triangles[3u * triangle + 2u].xyz;
    let d = frame.corner + frame.right * (f32(at.x) + 0.5) + frame.down * (f32(at.y) + 0.5);
    let weights = corner_weights(a, b, c, d);
    let point = a + ((b - a) * weights.x + (c - a) * weights.y);
    let shares = vec3(1.0 - weights.x - weights.y, weights.x, weights.y);
    // Normals are on the side of the facet's own normal, which may be turned from the viewer.
    let own = vec3(triangles[3u * triangle].w, triangles[3u * triangle + 1u].w, triangles[3u * triangle + 2u].w);
    let side = select(1.0, -1.0, dot3(own, up) < 0.0);
    var corners = array(a, b, c);
    var moved = point;
    var shading = vec3(0.0);
    for (var corner = 0u; corner < 3u; corner++) {
        let towards = normals[corner] * side;
        let below = min(dot3(point - corners[corner], towards), 0.0);
        moved -= towards * (RISE * shares[corner] * below);
        shading += towards * shares[corner];
    }
    let extents = max(max(abs(b - a), abs(c - b)), abs(a - c));
    position[pixel] = vec4(moved + up * offset_on(moved, up, extents), position[pixel].w);
    normal[pixel + frame.shading] = vec4(bitcast<vec3<u32>>(normalize(shading)), flat.w);
}
