// Split test of tested cells (Koa17 §3.3.4–3.3.6, §3.4), per cell: from its sub-fragments' masks to kept,
// black or split.
//@ needs shared/children shared/counters shared/query
//@ reads wanted visible
//@ writes queries samples

// True if cells get the value 0 when no sub-fragment sees any light.
override DARK_CULLING: bool = true;
// True if every stable cell above level 2 gets three additional level-0 samples.
override ADDITIONAL_SAMPLES: bool = true;

// Masks of one quadrant for 32 samples.
struct QuadrantMask {
    known: u32,
    visible: u32,
}

// Quadrants around the ring, as indices of rows of two.
const RING: array<u32, 4> = array(0u, 1u, 3u, 2u);

@compute @workgroup_size(64)
fn split_test(here: Lane) {
    let first = invocation(here) * frame.slots;
    if first >= atomicLoad(&counters[END]) {
        return;
    }
    let index = queries[first].place;
    let cell = cell_of(index - level_first(frame.level));
    var ring = RING;
    var differing = 0u;
    var any_visible = 0u;
    var gradient = array<u32, 4>();
    for (var word = 0u; word < frame.pattern.words; word++) {
        var quadrants = array<QuadrantMask, 4>();
        for (var part = 0u; part < frame.slots; part++) {
            let at = (first + part) * frame.pattern.words + word;
            let quadrant = part * 4u / frame.slots;
            quadrants[quadrant].known |= wanted[at];
            quadrants[quadrant].visible |= visible[at] & wanted[at];
        }
        var lit = 0u;
        var unlit = 0u;
        for (var quadrant = 0u; quadrant < 4u; quadrant++) {
            lit |= quadrants[quadrant].visible;
            unlit |= quadrants[quadrant].known & ~quadrants[quadrant].visible;
        }
        any_visible |= lit;
        // The OR of all six pairwise XORs (Eq. 1), over bits that both sides know.
        differing += countOneBits(lit & unlit);
        for (var edge = 0u; edge < 4u; edge++) {
            let a = quadrants[ring[edge]];
            let b = quadrants[ring[(edge + 1u) % 4u]];
            gradient[edge] += countOneBits((a.visible ^ b.visible) & a.known & b.known);
        }
    }
    let dark = any_visible == 0u && DARK_CULLING;
    if dark || differing <= frame.split_above {
        keep(first, index, cell, dark);
        return;
    }
    queries[first].place = NONE;
    var deep = 0u;
    for (var edge = 0u; edge < 4u; edge++) {
        if gradient[edge] > frame.gradient_above {
            deep |= (1u << ring[edge]) | (1u << ring[(edge + 1u) % 4u]);
        }
    }
    split(cell, deep);
}

fn split(cell: vec2<u32>, deep: u32) {
    let level = frame.level;
    for (var quadrant = 0u; quadrant < 4u; quadrant++) {
        let child = 2u * cell + vec2(quadrant & 1u, quadrant >> 1u);
        if any(child >= level_size(level - 1u)) {
            continue;
        }
        if ((deep >> quadrant) & 1u) != 0u && level >= 2u {
            mark_children(level - 1u, child, PENDING);
        } else {
            cells[cell_index(level - 1u, child)].state = PENDING;
        }
    }
}

fn keep(first: u32, index: u32, cell: vec2<u32>, dark: bool) {
    samples[index] = centre_sample(first);
    let additional = !dark && ADDITIONAL_SAMPLES && frame.level > 2u;
    cells[index].kept = select(KEPT, KEPT_MORE, additional);
    if !additional {
        return;
    }
    let corner = cell << vec2(frame.level);
    let half = 1u << (frame.level - 1u);
    for (var sample = 0u; sample < 3u; sample++) {
        let at = corner + half * vec2(sample & 1u, sample >> 1u);
        if at.x < frame.width && at.y < frame.height {
            cells[at.y * frame.width + at.x].state = ADDITIONAL;
        }
    }
}

// Sample of a whole cell: at the mean of the pixels from which its rays started. The nearest of these is its
// representative pixel.
fn centre_sample(first: u32) -> Sample {
    var at = vec2(0.0);
    var found = 0.0;
    for (var part = 0u; part < frame.slots; part++) {
        let query = queries[first + part];
        if query.asked > 0u {
            at += pixel_middle(query.pixel);
            found += 1.0;
        }
    }
    at = select(vec2(0.5), at / found, found > 0.0);
    var pixel = 0u;
    var nearest = 3e38;
    for (var part = 0u; part < frame.slots; part++) {
        let query = queries[first + part];
        let off = pixel_middle(query.pixel) - at;
        let distance = off.x * off.x + off.y * off.y;
        if query.asked > 0u && distance < nearest {
            pixel = query.pixel;
            nearest = distance;
        }
    }
    return Sample(at, NO_VALUE, pixel);
}

fn pixel_middle(pixel: u32) -> vec2<f32> {
    return vec2(f32(pixel % frame.width), f32(pixel / frame.width)) + 0.5;
}
