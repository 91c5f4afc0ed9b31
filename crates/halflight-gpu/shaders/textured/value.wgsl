// Values of samples under a textured light, from the masks of their queries, by channel.
//@ needs textured/sums
//@ writes channels

// Visible fractions of `count` queries from `first` on, together, as those of one query.
fn colours_of_queries(first: u32, count: u32) -> vec4<f32> {
    var all = Sums(vec3(0.0), vec3(0.0));
    for (var part = 0u; part < count; part++) {
        let sums = query_sums(first + part);
        all = Sums(all.visible + sums.visible, all.all + sums.all);
    }
    return colours_of(all);
}

// Irradiance per radiance of `count` queries from `first` on, together. Green stands for the whole.
fn irradiance_of_queries(first: u32, count: u32) -> vec4<f32> {
    var sum = vec3(0.0);
    var asked = 0u;
    for (var part = 0u; part < count; part++) {
        sum += query_sampled(first + part);
        asked += queries[first + part].asked;
    }
    sum /= f32(max(asked, 1u));
    return vec4(sum, sum.y);
}

// Keeps the channels of a sample, and returns its value.
fn keep_colours(place: u32, colours: vec4<f32>) -> f32 {
    channels[place] = vec4(colours.xyz, 1.0);
    return colours.w;
}
