// Computes surface attributes at each pixel's centre, per pixel: from the ID image to position, normal and
// albedo (halflight-cpu/src/gbuffer.rs).
//@ needs shared/offset shared/corner_weights
//@ reads triangles faces materials uvs textures ids
//@ writes position normal albedo

struct Material {
    albedo: vec3<f32>,
    // Index of the first texel, or NONE.
    texels: u32,
    size: vec2<u32>,
}

@compute @workgroup_size(8, 8)
fn resolve(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= frame.width || at.y >= frame.height {
        return;
    }
    let pixel = at.y * frame.width + at.x;
    let triangle = textureLoad(ids, at.xy, 0).x;
    if triangle == NONE {
        position[pixel] = vec4(0.0, 0.0, 0.0, -1.0);
        normal[pixel] = vec4(0u, 0u, 0u, NONE);
        albedo[pixel] = vec4(0.0);
        return;
    }
    let d = frame.corner + frame.right * (f32(at.x) + 0.5) + frame.down * (f32(at.y) + 0.5);
    let a = triangles[3u * triangle];
    let b = triangles[3u * triangle + 1u];
    let c = triangles[3u * triangle + 2u];
    var up = vec3(a.w, b.w, c.w);
    let weights = corner_weights(a.xyz, b.xyz, c.xyz, d);
    let depth = dot3(up, a.xyz - frame.eye) / dot3(up, d);
    if dot3(up, d) > 0.0 {
        up = -up;
    }
    let point = a.xyz + ((b.xyz - a.xyz) * weights.x + (c.xyz - a.xyz) * weights.y);
    let extents = max(max(abs(b.xyz - a.xyz), abs(c.xyz - b.xyz)), abs(a.xyz - c.xyz));
    position[pixel] = vec4(point + up * offset_on(point, up, extents), depth);
    normal[pixel] = vec4(bitcast<vec3<u32>>(up), faces[triangle].x);
    albedo[pixel] = vec4(albedo_of(triangle, weights), 1.0);
}

fn albedo_of(triangle: u32, weights: vec2<f32>) -> vec3<f32> {
    let material = materials[faces[triangle].y];
    if material.texels == NONE {
        return material.albedo;
    }
    let a = uvs[3u * triangle];
    let uv = a + ((uvs[3u * triangle + 1u] - a) * weights.x + (uvs[3u * triangle + 2u] - a) * weights.y);
    return material.albedo * bilinear(material, uv);
}

// Bilinear texture lookup at `uv`, repeated beyond the unit square; texel centres lie at half-integers, (0,
// 0) is the lower left.
fn bilinear(material: Material, uv: vec2<f32>) -> vec3<f32> {
    let unit = vec2(uv.x, 1.0 - uv.y);
    let at = (unit - floor(unit)) * vec2<f32>(material.size) - 0.5;
    let low = floor(at);
    let part = at - low;
    let x = vec2<u32>(vec2<i32>(low) + vec2<i32>(material.size)) % material.size;
    let y = (x + 1u) % material.size;
    let top = mix(texel(material, x), texel(material, vec2(y.x, x.y)), part.x);
    let bottom = mix(texel(material, vec2(x.x, y.y)), texel(material, y), part.x);
    return mix(top, bottom, part.y);
}

fn texel(material: Material, at: vec2<u32>) -> vec3<f32> {
    let channels = textures[material.texels + at.y * material.size.x + at.x];
    return vec3(linear(channels), linear(channels >> 8u), linear(channels >> 16u));
}

// Linear value of the lowest byte, from the table before the texels.
fn linear(channel: u32) -> f32 {
    return bitcast<f32>(textures[channel & 0xffu]);
}
