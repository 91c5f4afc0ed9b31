// Upsampling by Gaussian radial basis functions (Koa16 §3.1.5, Koa17 §3.6), per pixel: from up to three
// samples (halflight-cpu/src/upsample/rbf.rs).
//@ needs shared/additional upsample/pixels

override VARIANCE: f32 = 2.0;
override REACH: f32 = 2.0;
// True if the variance follows the samples' levels.
override ADAPTIVE: bool = false;

// Most samples of one edge.
const MOST: u32 = 192u;
// Determinant below which no digit of the weights is left.
const SINGULAR: f32 = 1e-6;

// Sample that contributes to a pixel.
struct Basis {
    at: vec2<f32>,
    value: f32,
    level: f32,
    // Squared distance from the pixel, in widths of its cell.
    distance: f32,
    place: u32,
}

// Outer edge of the pixel's quadrant.
struct Edge {
    // True for an edge along a row.
    level: bool,
    line: f32,
    low: u32,
    high: u32,
}

// Pixel, width of its cell, samples chosen so far, and the nearest sample on an edge.
var<private> pixel_at: vec2<f32>;
var<private> width: f32;
var<private> chosen: array<Basis, 3>;
var<private> chosen_count: u32;
var<private> best: Basis;
var<private> found: bool;
var<private> used_count: u32;

fn value_at(at: vec2<u32>, owner: Owner) -> f32 {
    let size = 1u << owner.level;
    let corner = owner.cell * size;
    let beyond = at >= corner + size / 2u;
    let first = corner + select(vec2(0u), vec2(size / 2u), beyond);
    let last = min(first + size / 2u, vec2(frame.width, frame.height));
    let lines = vec2<f32>(corner + select(vec2(0u), vec2(size), beyond));
    pixel_at = vec2<f32>(at) + 0.5;
    width = f32(size);
    chosen[0] = basis(owner_place(owner), owner.level);
    chosen_count = 1u;
    let row = Edge(true, lines.y, first.x, last.x);
    search_edge(owner, row, corner.y, beyond.y, frame.height);
    choose_nearest();
    let column = Edge(false, lines.x, first.y, last.y);
    search_edge(owner, column, corner.x, beyond.x, frame.width);
    choose_nearest();
    return mixed();
}

fn choose_nearest() {
    if found {
        chosen[chosen_count] = best;
        chosen_count += 1u;
    }
}

// Searches the samples on an edge: the cell's own additional ones, and those of the cells across it. `start`
// is the cell's first row or column across the edge, and `end` that of the image's end.
fn search_edge(owner: Owner, edge: Edge, start: u32, beyond: bool, end: u32) {
    found = false;
    used_count = 0u;
    search_additional(owner, edge);
    let across = select(start - 1u, start + (1u << owner.level), beyond);
    if select(start == 0u, across >= end, beyond) {
        return;
    }
    var along = edge.low;
    while along < edge.high {
        let at = select(vec2(across, along), vec2(along, across), edge.level);
        let other = owner_at(at);
        if other.level == NONE {
            along += 1u;
            continue;
        }
        add_candidate(owner_place(other), other.level);
        search_additional(other, edge);
        let last = owner_rect(other).last;
        along = select(last.y, last.x, edge.level);
    }
}

// Searches the additional samples of a cell on an edge: those within a pixel of the line and of its ends.
fn search_additional(owner: Owner, edge: Edge) {
    for (var number = 0u; number < additional_count(owner); number++) {
        let place = additional_place(owner, number);
        if place == NONE {
            continue;
        }
        let at = samples[place].at;
        let along = select(at.y, at.x, edge.level);
        let off = abs(select(at.x, at.y, edge.level) - edge.line);
        if off <= 1.0 && along >= f32(edge.low) - 1.0 && along <= f32(edge.high) + 1.0 {
            add_candidate(place, 0u);
        }
    }
}

fn add_candidate(place: u32, level: u32) {
    if used_count == MOST {
        return;
    }
    used_count += 1u;
    for (var number = 0u; number < chosen_count; number++) {
        if chosen[number].place == place {
            return;
        }
    }
    let other = basis(place, level);
    if other.distance < select(REACH * REACH, best.distance, found) {
        best = other;
        found = true;
    }
}

fn basis(place: u32, level: u32) -> Basis {
    let sample = samples[place];
    // An undefined value counts as 0.
    let distance = squared_distance(pixel_at - sample.at);
    return Basis(sample.at, max(sample.value, 0.0), f32(level), distance, place);
}

fn squared_distance(off: vec2<f32>) -> f32 {
    return (off.x * off.x + off.y * off.y) / (width * width);
}

// Variance scaling factor (Koa17 Eq. 6).
fn variance() -> f32 {
    if !ADAPTIVE {
        return VARIANCE;
    }
    var lowest = chosen[0].level;
    for (var number = 1u; number < chosen_count; number++) {
        lowest = min(lowest, chosen[number].level);
    }
    let narrowest = exp2(lowest);
    var sum = 0.0;
    var total = 0.0;
    for (var number = 0u; number < chosen_count; number++) {
        let weight = exp(-chosen[number].distance / (2.0 * narrowest));
        sum += weight * chosen[number].level;
        total += weight;
    }
    return VARIANCE * (select(0.0, sum / total, total > 0.0) + 1.0);
}

fn mixed() -> f32 {
    let scale = variance();
    if chosen_count == 3u {
        let solved = solve(chosen[0], chosen[1], chosen[2], scale);
        if solved >= 0.0 {
            return solved;
        }
    }
    // Normalised weights (Koa16 Eq. 3, Koa17 Eq. 9).
    var sum = 0.0;
    var total = 0.0;
    for (var number = 0u; number < chosen_count; number++) {
        let weight = exp(-chosen[number].distance / scale);
        sum += weight * chosen[number].value;
        total += weight;
    }
    return select(0.0, sum / total, total > 0.0);
}

// Koa17 Eq. 4 and 5a, by Cramer's rule; below 0 where the matrix is singular.
fn solve(a: Basis, b: Basis, c: Basis, scale: f32) -> f32 {
    let ab = exp(-squared_distance(a.at - b.at) / scale);
    let ac = exp(-squared_distance(a.at - c.at) / scale);
    let bc = exp(-squared_distance(b.at - c.at) / scale);
    let determinant = 1.0 + 2.0 * ab * ac * bc - ab * ab - ac * ac - bc * bc;
    if !(determinant > SINGULAR) {
        return -1.0;
    }
    // Rows of the adjugate.
    let wa = (1.0 - bc * bc) * a.value + (ac * bc - ab) * b.value + (ab * bc - ac) * c.value;
    let wb = (ac * bc - ab) * a.value + (1.0 - ac * ac) * b.value + (ab * ac - bc) * c.value;
    let wc = (ab * bc - ac) * a.value + (ab * ac - bc) * b.value + (1.0 - ab * ab) * c.value;
    let sum = wa * exp(-a.distance / scale) + wb * exp(-b.distance / scale) + wc * exp(-c.distance / scale);
    // Between samples the Gaussians can be negative, which neither irradiance nor a visible fraction is.
    return max(sum / determinant, 0.0);
}
