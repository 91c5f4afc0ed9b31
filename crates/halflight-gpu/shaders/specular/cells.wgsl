// A light as triangles that are small beside a lobe, one after another, and what the lobe reflects of each
// (halflight-cpu/src/specular/cells.rs). The CPU keeps them; here they are found once for their sum and once more where
// shadow rays go to them.
//@ needs shared/light specular/lobe

// Corners of the polygons that stand for an ellipse, for wide lobes and for narrow ones, and the square of the distance
// of their corners from the centre: polygons of the ellipse's area.
const WIDE_ELLIPSE: u32 = 12u;
const NARROW_ELLIPSE: u32 = 32u;

// Width of a narrow lobe in angles that the light subtends.
const NARROW: f32 = 0.25;

// Longest side of a triangle in distances from the receiver, and longest angle in angles to the middle of the lobe, or in
// widths of the lobe.
const BY_DISTANCE: f32 = 1.2;
const BY_ANGLE: f32 = 1.5;

const MOST_HALVINGS: u32 = 40u;
const MOST_CELLS: u32 = 4096u;

// Most corners of a clipped outline: clipping adds at most one to a convex polygon.
const MOST_CORNERS: u32 = 36u;

// Gauss's rule of four points on 0 … 1, and that for the weight 1 − x there (Gauss–Jacobi): points and weights.
const GAUSS_POINTS = vec4(0.06943184, 0.3300095, 0.6699905, 0.93056816);
const GAUSS_WEIGHTS = vec4(0.17392742, 0.32607258, 0.32607258, 0.17392742);
const JACOBI_POINTS = vec4(0.057104196, 0.276843, 0.58359045, 0.86024016);
const JACOBI_WEIGHTS = vec4(0.27101383, 0.40692914, 0.25969508, 0.06236194);

// The light as a receiver sees it.
struct Emitter {
    // First corner from the receiver, and edges.
    corner: vec3<f32>,
    u: vec3<f32>,
    v: vec3<f32>,
    // Normal on the receiver's side, with the length of the frame's area.
    towards: vec3<f32>,
}

// Triangle in the unit square of the light.
struct Cell3 {
    a: vec2<f32>,
    b: vec2<f32>,
    c: vec2<f32>,
    halvings: u32,
}

// Triangles that are left. One of the outline's fan is taken at a time, and each halving leaves one more than there were.
struct Walk {
    clipped: array<vec2<f32>, MOST_CORNERS>,
    corners: u32,
    next: u32,
    left: array<Cell3, MOST_HALVINGS + 2u>,
    waiting: u32,
    found: u32,
}

fn emitter_from(origin: vec3<f32>, towards: vec3<f32>) -> Emitter {
    let seen = seen_light(origin);
    if is_sphere() {
        return Emitter(seen.corner - origin, seen.u, seen.v, towards * length3(cross3(seen.u, seen.v)));
    }
    return Emitter(seen.corner - origin, seen.u, seen.v, light_cross_towards(towards));
}

// Vector across a part of the unit square.
fn along(emitter: Emitter, part: vec2<f32>) -> vec3<f32> {
    return emitter.u * part.x + emitter.v * part.y;
}

fn point_of(emitter: Emitter, uv: vec2<f32>) -> vec3<f32> {
    return emitter.corner + along(emitter, uv);
}

// Light that the lobe reflects around a point, per area of the unit square and unit radiance, and Schlick's weight.
fn reflected_at(emitter: Emitter, lobe: Lobe, to: vec3<f32>) -> vec2<f32> {
    let squared = max(dot3(to, to), 1.2e-38);
    let inverse = 1.0 / sqrt(squared);
    let found = lobe_reflected(lobe, to * inverse);
    let solid = max(-dot3(to, emitter.towards), 0.0) * inverse / squared;
    return vec2(found.x * solid, found.y);
}

fn start_walk(walk: ptr<function, Walk>, emitter: Emitter, lobe: Lobe) {
    (*walk).waiting = 0u;
    (*walk).found = 0u;
    (*walk).next = 2u;
    (*walk).corners = 0u;
    let middle = point_of(emitter, vec2(0.5));
    let wide = length3(middle) * lobe.width > NARROW * (length3(emitter.u) + length3(emitter.v));
    let count = outline_corners(select(NARROW_ELLIPSE, WIDE_ELLIPSE, wide));
    var inside = true;
    for (var corner = 0u; corner < 4u; corner++) {
        // The outline lies in the frame, but for the corners of a circle, by a hundredth.
        let place = vec2(f32(corner & 1u), f32(corner >> 1u)) * 1.02 - 0.01;
        inside &= dot3(point_of(emitter, place), lobe.normal) > 0.0;
    }
    // Parts below the horizon are clipped (Sutherland and Hodgman 1974).
    for (var index = 0u; index < count; index++) {
        let corner = outline_corner(index, count);
        if inside {
            push_corner(walk, corner);
            continue;
        }
        let next = outline_corner((index + 1u) % count, count);
        let here = dot3(point_of(emitter, corner), lobe.normal);
        let there = dot3(point_of(emitter, next), lobe.normal);
        if here > 0.0 {
            push_corner(walk, corner);
        }
        if (here > 0.0) != (there > 0.0) {
            push_corner(walk, corner + (next - corner) * (here / (here - there)));
        }
    }
}

fn push_corner(walk: ptr<function, Walk>, corner: vec2<f32>) {
    (*walk).clipped[min((*walk).corners, MOST_CORNERS - 1u)] = corner;
    (*walk).corners += 1u;
}

// Number of corners of the outline, where an ellipse has this many.
fn outline_corners(ellipse: u32) -> u32 {
    switch frame.outline.x {
        case PARALLELOGRAM: { return 4u; }
        case ELLIPSE, SPHERE: { return ellipse; }
        default: { return frame.outline.x; }
    }
}

fn outline_corner(index: u32, count: u32) -> vec2<f32> {
    switch frame.outline.x {
        case PARALLELOGRAM: {
            return vec2(f32(index == 1u || index == 2u), f32(index > 1u));
        }
        case ELLIPSE, SPHERE: {
            let step = 2.0 * PI / f32(count);
            let turn = f32(index) * step;
            return vec2(cos(turn), sin(turn)) * (0.5 * sqrt(step / sin(step))) + 0.5;
        }
        default: {
            let dual = light_dual();
            let corner = frame.outline_corners[index].xyz;
            return vec2(dot3(dual.u, corner), dot3(dual.v, corner));
        }
    }
}

// Finds the next triangle that is small enough; false where none is left.
fn next_cell(walk: ptr<function, Walk>, emitter: Emitter, lobe: Lobe, cell: ptr<function, Cell3>) -> bool {
    loop {
        if (*walk).waiting == 0u {
            let next = (*walk).next;
            if next >= min((*walk).corners, MOST_CORNERS) {
                return false;
            }
            (*walk).left[0] = Cell3((*walk).clipped[0], (*walk).clipped[next - 1u], (*walk).clipped[next], 0u);
            (*walk).waiting = 1u;
            (*walk).next = next + 1u;
        }
        (*walk).waiting -= 1u;
        let here = (*walk).left[(*walk).waiting];
        let p = point_of(emitter, here.a);
        let q = point_of(emitter, here.b);
        let r = point_of(emitter, here.c);
        let lengths = vec3(dot3(p - q, p - q), dot3(q - r, q - r), dot3(r - p, r - p));
        let more = here.halvings < MOST_HALVINGS && (*walk).found + (*walk).waiting < MOST_CELLS;
        if !more || !is_large(p, q, r, sqrt(max(lengths.x, max(lengths.y, lengths.z))), lobe) {
            (*walk).found += 1u;
            *cell = here;
            return true;
        }
        var turned = here;
        if lengths.x < lengths.y || lengths.x < lengths.z {
            if lengths.y >= lengths.z {
                turned = Cell3(here.b, here.c, here.a, here.halvings);
            } else {
                turned = Cell3(here.c, here.a, here.b, here.halvings);
            }
        }
        let middle = (turned.a + turned.b) * 0.5;
        (*walk).left[(*walk).waiting] = Cell3(turned.a, middle, turned.c, here.halvings + 1u);
        (*walk).left[(*walk).waiting + 1u] = Cell3(middle, turned.b, turned.c, here.halvings + 1u);
        (*walk).waiting += 2u;
    }
    return false;
}

// True if a triangle is too large for the rule.
fn is_large(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, longest: f32, lobe: Lobe) -> bool {
    let centre = (a + b + c) * (1.0 / 3.0);
    let distance = sqrt(dot3(centre, centre));
    // No corner is farther from the centre.
    let reach = longest * (2.0 / 3.0);
    if longest > BY_DISTANCE * max(distance - reach, 0.25 * distance) {
        return true;
    }
    let off = centre / distance - lobe.mirrored;
    let angle = sqrt(dot3(off, off)) - reach / distance;
    return longest > BY_ANGLE * distance * (max(angle, 0.0) + lobe.width);
}

// Light that the lobe reflects of a part of the light, per unit radiance and by channel, without the Fresnel term and by
// Schlick's weight; and the share by which the part is chosen.
struct Reflected {
    all: vec3<f32>,
    grazing: vec3<f32>,
    share: f32,
}

// Light that the lobe reflects of a triangle, by the product rule of degree 7 (Stroud's conical product).
fn reflected_of(emitter: Emitter, lobe: Lobe, cell: Cell3) -> Reflected {
    let ab = cell.b - cell.a;
    let ac = cell.c - cell.a;
    let area = 0.5 * abs(ab.x * ac.y - ab.y * ac.x);
    let corner = point_of(emitter, cell.a);
    let first = along(emitter, ab);
    let second = along(emitter, ac);
    var points = array(GAUSS_POINTS, GAUSS_WEIGHTS, JACOBI_POINTS, JACOBI_WEIGHTS);
    var sum = Reflected(vec3(0.0), vec3(0.0), 0.0);
    for (var point = 0u; point < 16u; point++) {
        let x = points[2][point >> 2u];
        let y = points[0][point & 3u] * (1.0 - x);
        let found = reflected_at(emitter, lobe, corner + first * x + second * y);
        let weight = points[3][point >> 2u] * points[1][point & 3u] * area;
        let value = factors_around(cell.a + ab * x + ac * y, sqrt(weight)) * (found.x * weight);
        sum.all += value;
        sum.grazing += value * found.y;
    }
    sum.share = share_of(sum.all);
    return sum;
}
