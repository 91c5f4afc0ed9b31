// Sums over light samples, per query: in the summation order of the CPU.
//@ needs shared/light shared/query shared/query_kinds shared/receiver
//@ reads queries wanted visible

struct Sums {
    // Sums of geometry terms of the visible samples, and of all.
    visible: f32,
    all: f32,
    // Number of samples asked for.
    count: u32,
}

// Number of lanes that the CPU sums separately.
const LANES: u32 = 16u;

fn query_sums(query: u32) -> Sums {
    let asked = queries[query];
    var sums = Sums(0.0, 0.0, asked.asked);
    if asked.pixel == NONE {
        return sums;
    }
    let receiver = receiver_at(asked.pixel);
    if surrounded(receiver.origin) {
        return surrounded_sums(receiver, asked.asked);
    }
    let light = seen_light(receiver.origin);
    let towards = facing(receiver.origin);
    if all(towards == vec3(0.0)) {
        return sums;
    }
    let first = query * frame.pattern.words;
    for (var lane = 0u; lane < min(LANES, frame.pattern.count); lane++) {
        var lit = 0.0;
        var both = 0.0;
        for (var index = lane; index < frame.pattern.count; index += LANES) {
            let word = first + index / 32u;
            if ((wanted[word] >> (index & 31u)) & 1u) == 0u {
                continue;
            }
            let d = seen_point(light, sample_place(index, asked.key)) - receiver.origin;
            let term = geometry_term(d, receiver.normal, towards);
            both += term;
            if ((visible[word] >> (index & 31u)) & 1u) != 0u {
                lit += term;
            }
        }
        sums.visible += lit;
        sums.all += both;
    }
    if is_sphere() {
        // Sums are over areas of the sphere's own frame.
        let scale = dot3(light.u, light.u) / frame.light_area;
        sums.visible *= scale;
        sums.all *= scale;
    }
    return sums;
}

// Sums of a receiver inside a sphere, which is lit from everywhere, or on it, before which half of space is light.
fn surrounded_sums(receiver: Receiver, asked: u32) -> Sums {
    let outside = length3(receiver.origin - sphere().xyz) > sphere().w;
    let half = 0.5 + 0.5 * dot3(receiver.normal, -sphere_facing(receiver.origin));
    let all = 3.14159265358979 * select(1.0, half, outside) / frame.light_area * f32(asked);
    return Sums(all, all, asked);
}

// Visible fraction of one query; NO_VALUE where every sample lies below a horizon.
fn query_fraction(query: u32) -> f32 {
    let kinds = lit_and_unlit(query);
    if !any(kinds) {
        return NO_VALUE;
    }
    if !all(kinds) {
        return select(0.0, 1.0, kinds.x);
    }
    return sums_fraction(query_sums(query));
}

fn sums_fraction(sums: Sums) -> f32 {
    if sums.all <= 0.0 {
        return NO_VALUE;
    }
    return sums.visible / sums.all;
}

// Irradiance per radiance.
fn sums_sampled(sums: Sums) -> f32 {
    if sums.count == 0u {
        return 0.0;
    }
    return frame.light_area * sums.visible / f32(sums.count);
}
