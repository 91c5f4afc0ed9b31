// Values of samples under a uniform light, from the masks of their queries: the same for red, green and blue.
//@ needs shared/sums

// Visible fractions of red, green, blue and the light as a whole, of one query.
fn query_colours(query: u32) -> vec4<f32> {
    return vec4(query_fraction(query));
}

// Visible fractions of `count` queries from `first` on, together.
fn colours_of_queries(first: u32, count: u32) -> vec4<f32> {
    return vec4(sums_fraction(sums_of_queries(first, count)));
}

// Irradiance per radiance of `count` queries from `first` on, together.
fn irradiance_of_queries(first: u32, count: u32) -> vec4<f32> {
    return vec4(sums_sampled(sums_of_queries(first, count)));
}

fn sums_of_queries(first: u32, count: u32) -> Sums {
    var all = Sums(0.0, 0.0, 0u);
    for (var part = 0u; part < count; part++) {
        let sums = query_sums(first + part);
        all = Sums(all.visible + sums.visible, all.all + sums.all, all.count + sums.count);
    }
    return all;
}

// Returns the value of a sample. Nothing but that is kept of it.
fn keep_colours(place: u32, colours: vec4<f32>) -> f32 {
    return colours.w;
}
