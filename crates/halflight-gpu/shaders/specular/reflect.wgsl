// Adds what surfaces reflect of one light specularly, per pixel: what the lobe reflects without occluders, times the part
// that arrives, by shadow rays to points that are distributed as the lobe reflects the light
// (halflight-cpu/src/specular.rs, halflight-cpu/src/specular/visible.rs).
//@ needs shared/receiver shared/counters specular/cells
//@ reads gloss
//@ writes specular

// Least and most shadow rays of a lobe, and the least where nothing else is known.
const LEAST_RAYS: u32 = 16u;
const MOST_RAYS: u32 = 4096u;
override RAYS: u32 = 64u;

// Distinguishes the random numbers of lobes from those of light samples.
const LOBES: u32 = 0x5bec0a11u;

// Knowledge of a pixel's lobe before any ray.
const LIT: u32 = 0u;
const DARK: u32 = 1u;
const OPEN: u32 = 2u;

var<workgroup> lobe_rays: atomic<u32>;

@compute @workgroup_size(8, 8)
fn reflect_light(here: Tile) {
    if here.at.x < frame.width && here.at.y < frame.height {
        let pixel = here.at.y * frame.width + here.at.x;
        var sum = select(specular[pixel].xyz, vec3(0.0), frame.light == 0u);
        if is_receiver(pixel) && any(gloss[pixel].xyz != vec3(0.0)) {
            sum += reflected_from(here.at.xy, pixel);
        }
        specular[pixel] = vec4(sum, 1.0);
    }
    workgroupBarrier();
    if here.lane == 0u {
        let bucket = (here.workgroup.x + 7u * here.workgroup.y) % BUCKETS;
        atomicAdd(&counters[TALLY + LOBE_RAYS * BUCKETS + bucket], atomicLoad(&lobe_rays));
    }
}

fn reflected_from(at: vec2<u32>, pixel: u32) -> vec3<f32> {
    let receiver = receiver_at(pixel);
    let towards = facing(receiver.origin);
    let known = known_at(at, pixel);
    // Surfaces inside a sphere reflect nothing of it.
    if known == DARK || all(towards == vec3(0.0)) || surrounded(receiver.origin) {
        return vec3(0.0);
    }
    let emitter = emitter_from(receiver.origin, towards);
    let surface = gloss[pixel];
    let lobe = lobe_of(receiver.normal, normalize(frame.eye - receiver.origin), surface.w);
    var walk: Walk;
    var cell: Cell3;
    var sum = Reflected(vec3(0.0), vec3(0.0), 0.0);
    start_walk(&walk, emitter, lobe);
    while next_cell(&walk, emitter, lobe, &cell) {
        let found = reflected_of(emitter, lobe, cell);
        if found.share > 0.0 {
            sum = Reflected(sum.all + found.all, sum.grazing + found.grazing, sum.share + found.share);
        }
    }
    if sum.share <= 0.0 {
        return vec3(0.0);
    }
    let unshadowed = frame.radiance * (surface.xyz * (sum.all - sum.grazing) + sum.grazing);
    if known == LIT {
        return unshadowed;
    }
    return unshadowed * visible_part(receiver.origin, emitter, lobe, sum.share, fold(fold(frame.key, pixel), LOBES));
}

// Visible part of what a lobe reflects, by channel. Points are chosen at equal steps through the sum of the triangles'
// shares, and uniformly in each.
fn visible_part(origin: vec3<f32>, emitter: Emitter, lobe: Lobe, whole: f32, key: u32) -> vec3<f32> {
    let count = clamp(max(RAYS, frame.pattern.count / 2u), LEAST_RAYS, MOST_RAYS);
    let shift = unit_pair(sample_bits(key, NONE)).x;
    let scramble = sample_bits(key, NONE - 1u);
    let step = whole / f32(count);
    var below = 0.0;
    var sample = 0u;
    var seen = vec3(0.0);
    var sum = vec3(0.0);
    var walk: Walk;
    var cell: Cell3;
    start_walk(&walk, emitter, lobe);
    while next_cell(&walk, emitter, lobe, &cell) {
        let share = reflected_of(emitter, lobe, cell).share;
        if share <= 0.0 {
            continue;
        }
        let ab = cell.b - cell.a;
        let ac = cell.c - cell.a;
        let area = 0.5 * abs(ab.x * ac.y - ab.y * ac.x);
        while sample < count {
            let place = (f32(sample) + shift) * step;
            if place >= below + share {
                break;
            }
            // The rest of the number is uniform inside the triangle's share; the other coordinate is van der
            // Corput's sequence, scrambled (Hammersley's points).
            let root = sqrt(clamp((place - below) / share, 0.0, 1.0));
            let across = f32((reverseBits(sample) ^ scramble) >> 8u) * (1.0 / 16777216.0);
            let uv = cell.a + ab * (root * (1.0 - across)) + ac * (root * across);
            let weight = factors_at(uv) * (reflected_at(emitter, lobe, point_of(emitter, uv)).x * area / share);
            sum += weight;
            if !is_lobe_hidden(origin, uv) {
                seen += weight;
            }
            sample++;
        }
        below += share;
    }
    atomicAdd(&lobe_rays, sample);
    // Channels in which nothing is emitted have no part, and need none.
    return select(seen / max(sum, vec3(1.2e-38)), vec3(0.0), sum <= vec3(0.0));
}

// True if geometry hides the point of the light at a place in the unit square that a receiver sees.
fn is_lobe_hidden(origin: vec3<f32>, uv: vec2<f32>) -> bool {
    let end = seen_point(seen_light(origin), uv);
    if is_sphere() {
        let stop = before_sphere(origin, end);
        return any(stop != origin) && occluded(origin, stop);
    }
    return occluded(origin, end);
}

// Knowledge from a visible fraction.
fn known_of(value: f32) -> u32 {
    return select(select(OPEN, DARK, value == 0.0), LIT, value == 1.0);
}
