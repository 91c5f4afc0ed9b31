// Computes sample values of a textured light, per sample: from the masks of its queries to visible fractions of red,
// green and blue, and of all together; or to irradiance of red, green and blue.
//@ needs shared/counters textured/sums
//@ writes samples channels

// Interpolated quantity: 0 irradiance, 1 the visible fraction.
override SHADING: u32 = 1u;

@compute @workgroup_size(64)
fn value(here: Lane) {
    let first = invocation(here) * frame.slots;
    if first >= atomicLoad(&counters[END]) {
        return;
    }
    let place = queries[first].place;
    if place == NONE {
        return;
    }
    var colours: vec4<f32>;
    if SHADING == 0u {
        var sampled = vec3(0.0);
        var asked = 0u;
        for (var part = 0u; part < frame.slots; part++) {
            sampled += query_sampled(first + part);
            asked += queries[first + part].asked;
        }
        colours = vec4(sampled / f32(max(asked, 1u)), 0.0);
        colours.w = colours.y;
    } else if frame.slots == 1u {
        colours = query_colours(first);
    } else {
        var all = Sums(vec3(0.0), vec3(0.0));
        for (var part = 0u; part < frame.slots; part++) {
            let sums = query_sums(first + part);
            all = Sums(all.visible + sums.visible, all.all + sums.all);
        }
        colours = colours_of(all);
    }
    samples[place].value = colours.w;
    channels[place] = vec4(colours.xyz, 1.0);
}
