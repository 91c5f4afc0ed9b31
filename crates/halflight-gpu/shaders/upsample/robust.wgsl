// Robust upsampling by compact radial basis functions with a linear term, aware of surfaces, per pixel
// (halflight-cpu/src/upsample/robust.rs).
//
// The CPU collects the samples around a piece of a cell, its part in a tile of 8 × 8, and fits the piece's
// pixels one by one. Here each pixel traverses the surroundings of its piece itself and sums up the samples,
// in the same order.
//@ needs shared/additional shared/tangent upsample/pixels
//@ reads trusts

// Radius of a sample's influence, in units of the spacing of samples in its cell.
override RADIUS: f32 = 2.0;
// Squared distance, in pixels, below which the weight of a sample stops growing.
override SOFTNESS: f32 = 1.0;
// Regularisation of the fit's slope.
override STIFFNESS: f32 = 0.1;

// Most samples that a pixel uses.
const MOST: u32 = 192u;

// Pixel and its piece.
var<private> pixel_at: vec2<f32>;
var<private> own: Tangent;
var<private> piece: Rect;

// Weighted sums of 1, x, y, v, x², xy, y², xv, yv relative to the pixel.
var<private> sums: array<f32, 9>;
// Bounds of the samples that were used, and of all.
var<private> low: f32;
var<private> high: f32;
var<private> lowest: f32;
var<private> highest: f32;
var<private> used_count: u32;

// Averages where no near sample shares a surface: by agreement, and by likeness. Sum, weight, and bounds.
var<private> agreeing: vec4<f32>;
var<private> alike: vec4<f32>;

// Origin of samples, which decides their use.
const OWN: u32 = 0u;
const AROUND: u32 = 1u;
const WIDE: u32 = 2u;

// Value of a pixel that is one of its cell's additional samples; negative where it is not.
fn exact_value(owner: Owner, pixel: u32) -> f32 {
    for (var number = 0u; number < additional_count(owner); number++) {
        if additional_place(owner, number) == pixel {
            return samples[pixel].value;
        }
    }
    return NO_VALUE;
}

fn value_at(at: vec2<u32>, owner: Owner) -> f32 {
    let pixel = at.y * frame.width + at.x;
    let exact = exact_value(owner, pixel);
    if exact >= 0.0 {
        return exact;
    }
    let rect = owner_rect(owner);
    let tile = at & vec2(0xfffffff8u);
    piece = Rect(max(rect.first, tile), min(rect.last, tile + 8u));
    pixel_at = vec2<f32>(at) + 0.5;
    own = tangent_at(pixel);
    sums = array<f32, 9>();
    low = 3e38;
    high = -3e38;
    lowest = 3e38;
    highest = -3e38;
    used_count = 0u;
    visit(owner, OWN);
    walk_around(rect, 1u, AROUND);
    if used_count > 0u && lowest == highest {
        // All samples around agree: every weighting gives the same value.
        return lowest;
    }
    if sums[0] > 1e-20 {
        return solved();
    }
    return averaged(owner, rect);
}

// Weighted least-squares plane through the samples, evaluated at the pixel.
fn solved() -> f32 {
    let scale = 1.0 / max(sums[0], 1e-20);
    let mx = sums[1] * scale;
    let my = sums[2] * scale;
    let mv = sums[3] * scale;
    // Rounding can make a spread negative; the padding covers it.
    let spread_x = sums[4] * scale - mx * mx;
    let spread_y = sums[6] * scale - my * my;
    let xy = sums[5] * scale - mx * my;
    let xv = sums[7] * scale - mx * mv;
    let yv = sums[8] * scale - my * mv;
    let padding = STIFFNESS * max(spread_x + spread_y, 0.0) + 1e-3 * (mx * mx + my * my) + 1e-4;
    let xx = max(spread_x, 0.0) + padding;
    let yy = max(spread_y, 0.0) + padding;
    let determinant = max(xx * yy - xy * xy, padding * padding * 0.5);
    let gx = (yy * xv - xy * yv) / determinant;
    let gy = (xx * yv - xy * xv) / determinant;
    return min(max(mv - gx * mx - gy * my, low), high);
}

// Average over two wider rings: of the samples on the pixel's surface by distance, or else of all by the
// match of their surfaces.
fn averaged(owner: Owner, rect: Rect) -> f32 {
    let size = 1u << owner.level;
    agreeing = vec4(0.0, 0.0, 3e38, -3e38);
    alike = agreeing;
    used_count = 0u;
    visit(owner, WIDE);
    walk_around(rect, 1u, WIDE);
    walk_around(rect, 2u + size, WIDE);
    walk_around(rect, 4u + 2u * size, WIDE);
    if agreeing.y > 0.0 {
        return clamp(agreeing.x / agreeing.y, agreeing.z, agreeing.w);
    }
    if alike.y > 0.0 {
        return clamp(alike.x / alike.y, alike.z, alike.w);
    }
    return 0.0;
}

// Visits the cells that touch the frame of pixels `margin` outside a rectangle, each once.
fn walk_around(rect: Rect, margin: u32, role: u32) {
    for (var side = 0u; side < 4u; side++) {
        let line = side_of(rect, margin, side);
        if line.z == NONE {
            continue;
        }
        let along_row = side == 0u || side == 3u;
        var along = line.x;
        while along < line.y {
            let at = select(vec2(line.z, along), vec2(along, line.z), along_row);
            let other = owner_at(at);
            if other.level == NONE {
                along += 1u;
                continue;
            }
            let area = owner_rect(other);
            along = select(area.last.y, area.last.x, along_row);
            if !was_met(area, rect, margin, side, role) {
                visit(other, role);
            }
        }
    }
}

// Side of such a frame, in the order top, left, right, bottom: start, end, and the row or column; NONE where
// it lies outside the image.
fn side_of(rect: Rect, margin: u32, side: u32) -> vec3<u32> {
    let image = vec2(frame.width, frame.height);
    let near = rect.first - min(rect.first, vec2(margin));
    let far = min(rect.last - 1u + margin, image - 1u);
    switch side {
        case 0u: { return vec3(near.x, far.x + 1u, select(NONE, rect.first.y - margin, rect.first.y >= margin)); }
        case 1u: { return vec3(near.y, far.y + 1u, select(NONE, rect.first.x - margin, rect.first.x >= margin)); }
        case 2u: { return vec3(near.y, far.y + 1u, select(NONE, far.x, far.x == rect.last.x - 1u + margin)); }
        default: { return vec3(near.x, far.x + 1u, select(NONE, far.y, far.y == rect.last.y - 1u + margin)); }
    }
}

fn touches(area: Rect, rect: Rect, margin: u32, side: u32) -> bool {
    let line = side_of(rect, margin, side);
    if line.z == NONE {
        return false;
    }
    if side == 0u || side == 3u {
        return area.first.y <= line.z && line.z < area.last.y && area.first.x < line.y && line.x < area.last.x;
    }
    return area.first.x <= line.z && line.z < area.last.x && area.first.y < line.y && line.x < area.last.y;
}

// True if a cell touches a side that was visited before, of this frame or, if there are several, of a
// narrower one.
fn was_met(area: Rect, rect: Rect, margin: u32, side: u32, role: u32) -> bool {
    for (var earlier = 0u; earlier < side; earlier++) {
        if touches(area, rect, margin, earlier) {
            return true;
        }
    }
    if role != WIDE || margin == 1u {
        return false;
    }
    for (var earlier = 0u; earlier < 4u; earlier++) {
        if touches(area, rect, 1u, earlier) {
            return true;
        }
        if margin == 4u + 2u * whole(rect) && touches(area, rect, 2u + whole(rect), earlier) {
            return true;
        }
    }
    return false;
}

// Size of the cell with this rectangle, which the image's border may have clipped.
fn whole(rect: Rect) -> u32 {
    return 1u << owners[rect.first.y * frame.width + rect.first.x];
}

// Adds all samples of a cell.
fn visit(owner: Owner, role: u32) {
    var count = 0u;
    for (var number = 0u; number < additional_count(owner); number++) {
        count += u32(additional_place(owner, number) != NONE);
    }
    // Spacing of samples: one cell where the cell has a single sample, half a cell where it has more.
    let size = f32(1u << owner.level);
    let reach = max(RADIUS, RADIUS * select(size, max(0.5 * size, 1.0), count > 0u));
    let place = owner_place(owner);
    add(place, reach, select(1.0, trusts[place], owner.level > 0u), role);
    for (var number = 0u; number < additional_count(owner); number++) {
        let additional = additional_place(owner, number);
        if additional != NONE {
            add(additional, reach, 1.0, role);
        }
    }
}

fn add(place: u32, reach: f32, trusted: f32, role: u32) {
    let sample = samples[place];
    if sample.value < 0.0 || used_count == MOST {
        return;
    }
    if role == AROUND {
        // Distance to the nearest pixel centre of the piece.
        let before = vec2<f32>(piece.first) + 0.5 - sample.at;
        let after = sample.at - vec2<f32>(piece.last) + 0.5;
        let off = max(max(before, after), vec2(0.0));
        if off.x * off.x + off.y * off.y >= reach * reach {
            return;
        }
    }
    used_count += 1u;
    let other = tangent_at(sample.pixel);
    if role == WIDE {
        mix_in(sample, other, trusted);
    } else {
        fit_in(sample, other, reach, trusted);
    }
}

fn fit_in(sample: Sample, other: Tangent, reach: f32, trusted: f32) {
    lowest = min(lowest, sample.value);
    highest = max(highest, sample.value);
    let inverse = 1.0 / (reach * reach);
    let d = sample.at - pixel_at;
    let away = (d.x * d.x + d.y * d.y) * inverse;
    let rest = max(1.0 - away, 0.0);
    let weight = trusted * agreement(own, other) * rest * rest / (away + SOFTNESS * inverse);
    let wx = weight * d.x;
    let wy = weight * d.y;
    sums[0] += weight;
    sums[1] += wx;
    sums[2] += wy;
    sums[3] += weight * sample.value;
    sums[4] += wx * d.x;
    sums[5] += wx * d.y;
    sums[6] += wy * d.y;
    sums[7] += wx * sample.value;
    sums[8] += wy * sample.value;
    if weight > 0.0 {
        low = min(low, sample.value);
        high = max(high, sample.value);
    }
}

fn mix_in(sample: Sample, other: Tangent, trusted: f32) {
    let d = sample.at - pixel_at;
    let near = d.x * d.x + d.y * d.y + 0.25;
    agreeing = mixed_with(agreeing, sample.value, trusted * agreement(own, other) / near);
    // Fit of a mixture: 1/2, since one that may contain the pixel's own surface is better than a pure sample
    // of another.
    var fit = 0.5;
    if trusted >= 0.5 {
        fit = likeness(own, other);
    }
    alike = mixed_with(alike, sample.value, fit / near);
}

fn mixed_with(mixture: vec4<f32>, value: f32, weight: f32) -> vec4<f32> {
    if weight <= 0.0 {
        return mixture;
    }
    let sums = mixture.xy + vec2(weight * value, weight);
    return vec4(sums, min(mixture.z, value), max(mixture.w, value));
}
