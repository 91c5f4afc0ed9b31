// Computes specular reflection of surfaces, per pixel: from the base colour in `albedo` to reflectance at normal
// incidence and roughness, and to the diffuse albedo (halflight-core/src/specular.rs).
//@ needs shared/surface
//@ reads faces glosses ids
//@ writes albedo gloss

struct Gloss {
    // Of what is not metal, at normal incidence.
    reflectance: vec3<f32>,
    roughness: f32,
    // Metallicity in the first component.
    metallic: vec4<f32>,
}

@compute @workgroup_size(8, 8)
fn resolve_specular(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= frame.width || at.y >= frame.height {
        return;
    }
    let pixel = at.y * frame.width + at.x;
    if !is_receiver(pixel) {
        gloss[pixel] = vec4(0.0, 0.0, 0.0, 1.0);
        return;
    }
    let found = glosses[faces[textureLoad(ids, at.xy, 0).x].y];
    let base = albedo[pixel].xyz;
    let metallic = found.metallic.x;
    gloss[pixel] = vec4(found.reflectance + (base - found.reflectance) * metallic, found.roughness);
    albedo[pixel] = vec4(base * (1.0 - metallic), 1.0);
}
