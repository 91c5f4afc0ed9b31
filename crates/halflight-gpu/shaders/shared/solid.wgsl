// Alpha test of a hit (halflight-cpu/src/occluder/alpha.rs): texels of all masks, row by row from the top, one bit each.
//@ needs shared/corner_weights shared/masked
//@ reads triangles solid

// True if the point where the line from `origin` along `d` meets a triangle with an alpha mask is solid. The line must meet the
// triangle.
fn is_solid(triangle: u32, origin: vec3<f32>, d: vec3<f32>) -> bool {
    let own = masked.triangles[triangle - masked.first];
    let a = triangles[3u * triangle].xyz;
    let b = triangles[3u * triangle + 1u].xyz;
    let c = triangles[3u * triangle + 2u].xyz;
    let weights = weights_along(a, b, c, origin, d);
    let uv = own.a + ((own.b - own.a) * weights.x + (own.c - own.a) * weights.y);
    // The part after the point can round up to 1.
    let place = min(vec2<u32>((uv - floor(uv)) * vec2<f32>(own.size)), own.size - 1u);
    // Texture coordinates grow upwards.
    let texel = (own.size.y - 1u - place.y) * own.size.x + place.x;
    return ((solid[own.texels + texel / 32u] >> (texel & 31u)) & 1u) == 1u;
}
