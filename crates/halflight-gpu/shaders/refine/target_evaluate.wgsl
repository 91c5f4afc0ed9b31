// Evaluates pilot samples, per query: from masks to squared irradiance and noise
// (halflight-cpu/src/refine/target.rs).
// `query_fraction` and `query_noise` are those of uniform or of textured lights.
//@ needs shared/query_batch shared/unshadowed
//@ writes samples

@compute @workgroup_size(64)
fn evaluate(here: Lane) {
    let query = query_of(invocation(here));
    if query == NONE {
        return;
    }
    let pixel = queries[query].pixel;
    let receiver = receiver_at(pixel);
    let bright = unshadowed(receiver.origin, receiver.normal);
    let seen = bright * max(query_fraction(query), 0.0);
    let noise = query_noise(query);
    samples[pixel] = Sample(vec2(seen * seen, bright * bright * noise.variance), noise.disagreement, pixel);
}
