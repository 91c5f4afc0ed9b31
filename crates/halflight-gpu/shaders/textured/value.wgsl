// Computes sample values of a textured light, per sample: from the masks of its queries to visible fractions of red,
// green and blue, and of all together.
//@ needs shared/counters textured/sums
//@ writes samples channels

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
    if frame.slots == 1u {
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
