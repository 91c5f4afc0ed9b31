// Sums over the samples of a textured light, per query, of red, green and blue: in the summation order of the CPU
// (halflight-cpu/src/textured/strata.rs).
//@ needs shared/light shared/query shared/query_kinds shared/receiver textured/strata textured/texel
//@ reads queries wanted visible

struct Sums {
    // Sums of radiance times geometry term of the visible samples, and of all.
    visible: vec3<f32>,
    all: vec3<f32>,
}

// Number of lanes that the CPU sums separately.
const LANES: u32 = 16u;

fn query_sums(query: u32) -> Sums {
    let asked = queries[query];
    var sums = Sums(vec3(0.0), vec3(0.0));
    if asked.pixel == NONE {
        return sums;
    }
    let receiver = receiver_at(asked.pixel);
    let towards = facing(receiver.origin);
    if all(towards == vec3(0.0)) {
        return sums;
    }
    let first = query * frame.pattern.words;
    let strata = strata_first();
    for (var lane = 0u; lane < min(LANES, frame.pattern.count); lane++) {
        var lit = vec3(0.0);
        var both = vec3(0.0);
        for (var index = lane; index < frame.pattern.count; index += LANES) {
            let word = first + index / 32u;
            if ((wanted[word] >> (index & 31u)) & 1u) == 0u {
                continue;
            }
            let d = sample_point(index, asked.key) - receiver.origin;
            let light = emitted[strata + index].xyz * geometry_term(d, receiver.normal, towards);
            both += light;
            if ((visible[word] >> (index & 31u)) & 1u) != 0u {
                lit += light;
            }
        }
        sums.visible += lit;
        sums.all += both;
    }
    return sums;
}

// Irradiance of red, green and blue per radiance of the light, of one query: by the texels that its samples lie on.
fn query_sampled(query: u32) -> vec3<f32> {
    let asked = queries[query];
    var sum = vec3(0.0);
    if asked.pixel == NONE || asked.asked == 0u {
        return sum;
    }
    let receiver = receiver_at(asked.pixel);
    let towards = facing(receiver.origin);
    if all(towards == vec3(0.0)) {
        return sum;
    }
    let first = query * frame.pattern.words;
    for (var index = 0u; index < frame.pattern.count; index++) {
        let word = first + index / 32u;
        if ((wanted[word] & visible[word]) >> (index & 31u) & 1u) != 0u {
            let place = sample_place(index, asked.key);
            sum += texel_at(place) * geometry_term(light_point(place) - receiver.origin, receiver.normal, towards);
        }
    }
    return sum * frame.light_area;
}

// Visible fractions of red, green and blue, and of the light as a whole: the ratio of the lengths. A channel of which
// nothing is emitted has that of the whole; all are NO_VALUE where every sample lies below a horizon or is black.
fn colours_of(sums: Sums) -> vec4<f32> {
    let whole = length(sums.all);
    if whole <= 0.0 {
        return vec4(NO_VALUE);
    }
    let fraction = length(sums.visible) / whole;
    let none = sums.all == vec3(0.0);
    let each = sums.visible / select(sums.all, vec3(1.0), none);
    return vec4(select(each, vec3(fraction), none), fraction);
}

// Visible fractions of one query.
fn query_colours(query: u32) -> vec4<f32> {
    let kinds = lit_and_unlit(query);
    if !any(kinds) {
        return vec4(NO_VALUE);
    }
    if !all(kinds) {
        return vec4(select(0.0, 1.0, kinds.x));
    }
    return colours_of(query_sums(query));
}

fn query_fraction(query: u32) -> f32 {
    return query_colours(query).w;
}
