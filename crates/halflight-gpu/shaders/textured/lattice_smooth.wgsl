// Smooths visible fractions of a textured light, per pixel with a mask: from fractions and their noise to samples, to
// channels behind those that are not smoothed, and to the noise that is left in `plane`
// (halflight-cpu/src/refine/lattice/denoise.rs).
//@ needs shared/smoothing
//@ writes samples plane channels

@compute @workgroup_size(8, 8)
fn smooth_fractions(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= frame.width || at.y >= frame.height {
        return;
    }
    let pixel = pixel_of(at.xy);
    let behind = arrayLength(&channels) / 2u;
    let own = channels[pixel];
    plane[pixel] = 0.0;
    channels[behind + pixel] = own;
    if fraction_at(pixel) < 0.0 {
        return;
    }
    let found = smoothed(at.xy);
    if !found.varies {
        return;
    }
    let sum = found.sum;
    samples[pixel].value = sum.fractions / sum.count;
    plane[pixel] = sum.variances / (sum.count * sum.count);
    channels[behind + pixel] = vec4(smoothed_colours(at.xy, own.xyz, found.pairs), own.w);
}

// Means over the pairs that agree in each channel as well: colours may change where their sum does not.
fn smoothed_colours(at: vec2<u32>, own: vec3<f32>, pairs: u32) -> vec3<f32> {
    var directions = DIRECTIONS;
    var strides = STRIDES;
    var fractions = own;
    var variances = noise_at(pixel_of(at));
    var count = 1.0;
    for (var number = 0u; number < 20u; number++) {
        if ((pairs >> number) & 1u) == 0u {
            continue;
        }
        let off = directions[number & 3u] * strides[number >> 2u];
        let a = neighbour(at, off);
        let b = neighbour(at, -off);
        let pair = channels[a].xyz + channels[b].xyz;
        let noise = noise_at(a) + noise_at(b);
        var agreed = true;
        for (var channel = 0u; channel < 3u; channel++) {
            agreed &= agree(Sum(fractions[channel], variances, count), Sum(pair[channel], noise, 2.0));
        }
        if agreed {
            fractions += pair;
            variances += noise;
            count += 2.0;
        }
    }
    return fractions / count;
}
