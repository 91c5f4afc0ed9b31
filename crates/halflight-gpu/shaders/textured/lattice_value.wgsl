// Computes visible fractions of a textured light at pixels that have just been traced, per query: from masks to
// fractions, of red, green and blue as well, and noise.
//@ needs shared/query_batch textured/noise textured/sums
//@ writes samples fractions channels

// Interpolated quantity: 0 irradiance, 1 the visible fraction.
override SHADING: u32 = 1u;

// True if the noise of the masks is needed.
override NOISY: bool = false;

@compute @workgroup_size(64)
fn value(here: Lane) {
    let query = query_of(invocation(here));
    if query == NONE {
        return;
    }
    let pixel = queries[query].pixel;
    let colours = query_colours(query);
    var variance = 0.0;
    if NOISY {
        variance = query_noise(query).variance;
    }
    fractions[pixel] = vec2(select(bitcast<u32>(colours.w) + 1u, 0u, colours.w < 0.0), bitcast<u32>(variance));
    let at = vec2(f32(pixel % frame.width), f32(pixel / frame.width)) + 0.5;
    samples[pixel] = Sample(at, colours.w, pixel);
    channels[pixel] = vec4(colours.xyz, 1.0);
    if SHADING == 0u {
        channels[pixel] = vec4(query_sampled(query) / f32(max(queries[query].asked, 1u)), 1.0);
    }
}
