// Chooses the sampling plan for an error target, once per light: from the pilot samples at the coarsest
// corners to a number of light samples and an interpolation tolerance. One workgroup sums in a fixed order,
// so that the result does not depend on scheduling.
//@ needs shared/cells shared/choice shared/query
//@ reads samples

// Error target (NMSE₂), its share for noise, and the interpolation tolerance before the bound by noise; see
// `Budget`.
override WHOLE_TARGET: f32 = 0.0;
override NOISE_TARGET: f32 = 0.0;
override INTERPOLATION: f32 = 0.0;

// Fewest samples along one side of the light where visible errors are bounded.
override LEAST_SIDE: u32 = 4u;

// Fewest and most samples along one side of the light, and number of pilot samples.
const LEAST: u32 = 4u;
const MOST: u32 = 20u;
const FIRST: u32 = 8u;
const PILOT: f32 = f32(FIRST * FIRST);
const SIDES: u32 = MOST - LEAST + 1u;

// Fraction of differing neighbours from which on samples are practically independent.
const INDEPENDENT: f32 = 0.35;

// Standard deviation of the visible fraction with the pilot samples, the power of their number with which it
// falls, and the least interpolation tolerance in standard deviations; then bounds on the tolerance.
const DEVIATION: f32 = 0.02;
const DECAY: f32 = 0.75;
const DEVIATIONS: f32 = 2.5;
const LEAST_ERROR: f32 = 0.01;
const MOST_ERROR: f32 = 0.3;

// Reciprocals of numbers of columns or rows: computed by the compiler, since division on the GPU may not
// round correctly.
const SCALES = array(
    1.0 / 4.0, 1.0 / 5.0, 1.0 / 6.0, 1.0 / 7.0, 1.0 / 8.0, 1.0 / 9.0, 1.0 / 10.0, 1.0 / 11.0, 1.0 / 12.0, 1.0 / 13.0,
    1.0 / 14.0, 1.0 / 15.0, 1.0 / 16.0, 1.0 / 17.0, 1.0 / 18.0, 1.0 / 19.0, 1.0 / 20.0,
);

var<workgroup> energies: array<f32, 64>;
var<workgroup> noises: array<array<f32, SIDES>, 64>;

@compute @workgroup_size(64)
fn choose(@builtin(local_invocation_index) lane: u32) {
    let size = level_size(frame.level) + 1u;
    let last = vec2(frame.width, frame.height) - 1u;
    var energy = 0.0;
    var noise: array<f32, SIDES>;
    for (var number = lane; number < size.x * size.y; number += 64u) {
        let corner = vec2(number % size.x, number / size.x);
        // Of corners that coincide at the image's border the first counts.
        if any((corner > vec2(0u)) & (((corner - 1u) << vec2(frame.level)) >= last)) {
            continue;
        }
        let place = min(corner << vec2(frame.level), last);
        let pixel = place.y * frame.width + place.x;
        if cells[pixel].slot == 0u {
            continue;
        }
        let pilot = samples[pixel];
        energy += pilot.at.x;
        if pilot.at.y > 0.0 {
            let power = 1.5 - 0.5 * min(pilot.value / INDEPENDENT, 1.0);
            for (var side = 0u; side < SIDES; side++) {
                let columns = f32(LEAST + side);
                noise[side] += pilot.at.y * pow(PILOT / (columns * columns), power);
            }
        }
    }
    energies[lane] = energy;
    noises[lane] = noise;
    workgroupBarrier();
    if lane > 0u {
        return;
    }
    for (var other = 1u; other < 64u; other++) {
        energy += energies[other];
        for (var side = 0u; side < SIDES; side++) {
            noise[side] += noises[other][side];
        }
    }
    let least = LEAST_SIDE - LEAST;
    let side = clamp(side_for(noise, NOISE_TARGET * energy), least, SIDES - 1u);
    let every = max(side_for(noise, WHOLE_TARGET * energy), least);
    chosen[0] = choice_of(side);
    // None in foliage: there the number of receivers that see part of the light decides, and interpolation
    // saves most of them.
    if every < SIDES {
        chosen[0].every = pattern_of(every);
    }
}

// Least number of samples whose noise is within the limit; SIDES if none is.
fn side_for(noise: array<f32, SIDES>, most: f32) -> u32 {
    var noises = noise;
    var side = 0u;
    while side < SIDES && noises[side] > most {
        side++;
    }
    return side;
}

fn pattern_of(side: u32) -> Pattern {
    let columns = LEAST + side;
    let count = columns * columns;
    var stride = (count + 63u) / 64u * 64u;
    if count <= 64u {
        stride = 16u;
        while stride < count {
            stride *= 2u;
        }
    }
    var scales = SCALES;
    return Pattern(frame.pattern.kind, columns, columns, count, (count + 31u) / 32u, stride, vec2(scales[side]));
}

fn choice_of(side: u32) -> Choice {
    let pattern = pattern_of(side);
    // Below the masks' own noise, pixels are no better than the values they replace.
    let deviation = DEVIATION * pow(PILOT / f32(pattern.count), DECAY);
    var none: Pattern;
    let error = clamp(max(INTERPOLATION, DEVIATIONS * deviation), LEAST_ERROR, MOST_ERROR);
    return Choice(pattern, error, frame.coarsest, none);
}
