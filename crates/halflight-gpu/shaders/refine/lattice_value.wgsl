// Computes visible fractions and sample values of pixels that have just been traced, per query: from masks to
// fractions, noise and values, of a uniform or of a textured light (shared/value and shared/noise, or their twins in textured).
//@ needs shared/query_batch
//@ reads queries
//@ writes samples fractions

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
    var colours = query_colours(query);
    let fraction = colours.w;
    var variance = 0.0;
    if NOISY {
        variance = query_noise(query).variance;
    }
    fractions[pixel] = vec2(select(bitcast<u32>(fraction) + 1u, 0u, fraction < 0.0), bitcast<u32>(variance));
    if SHADING == 0u {
        colours = irradiance_of_queries(query, 1u);
    }
    let at = vec2(f32(pixel % frame.width), f32(pixel / frame.width)) + 0.5;
    samples[pixel] = Sample(at, keep_colours(pixel, colours), pixel);
}
