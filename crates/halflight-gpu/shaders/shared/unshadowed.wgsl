// Analytic unshadowed irradiance of the light, per receiver (halflight-cpu/src/unshadowed.rs).
//
// Lambert's formula suffers from cancellation where the light subtends a small solid angle, and shading
// languages have no reliable double precision. There the light is cut into triangles, clipped to the horizon,
// and integrated by cubature: the integrand hardly varies, so a polynomial is accurate in single precision.
//@ needs shared/light

const PI: f32 = 3.14159265358979;

// Returns atan2(sine, cosine) / sine for sine ≥ 0. The argument of the arctangent is reduced to 0 … tan(π/8),
// where eight terms of its series are accurate to 1e-8.
fn angle_over_sine(sine: f32, cosine: f32) -> f32 {
    let magnitude = abs(cosine);
    let low = sine <= 0.41421357 * magnitude;
    let high = sine >= 2.4142137 * magnitude;
    var ratio = vec3(sine - magnitude, sine + magnitude, 0.25 * PI);
    if low {
        ratio = vec3(sine, magnitude, 0.0);
    } else if high {
        ratio = vec3(-magnitude, sine, 0.5 * PI);
    }
    let t = ratio.x / max(ratio.y, 1.17549435e-38);
    let z = t * t;
    var series = 0.0;
    for (var term = 8; term > 0; term--) {
        let sign = select(1.0, -1.0, (term & 1) == 1);
        series = (series + sign / f32(2 * term + 1)) * z;
    }
    let atan = ratio.z + (t + t * series);
    let angle = select(atan, PI - atan, cosine < 0.0);
    if low && cosine > 0.0 {
        return (1.0 + series) / magnitude;
    }
    return angle / max(sine, 1.17549435e-38);
}

// Part of the light above a receiver's horizon, relative to the receiver.
struct Polygon {
    corners: array<vec3<f32>, 6>,
    count: u32,
}

fn visible_polygon(origin: vec3<f32>, up: vec3<f32>) -> Polygon {
    var polygon: Polygon;
    var corners = light_corners_seen(origin);
    for (var index = 0u; index < 4u; index++) {
        let p = corners[index];
        let q = corners[(index + 1u) & 3u];
        let hp = dot3(up, p);
        let hq = dot3(up, q);
        if hp >= 0.0 {
            polygon.corners[polygon.count] = p;
            polygon.count += 1u;
        }
        if (hp > 0.0 && hq < 0.0) || (hp < 0.0 && hq > 0.0) {
            polygon.corners[polygon.count] = p + (q - p) * (hp / (hp - hq));
            polygon.count += 1u;
        }
    }
    return polygon;
}

fn lambert(polygon: Polygon, up: vec3<f32>) -> f32 {
    var corners = polygon.corners;
    var sum = 0.0;
    for (var index = 0u; index < polygon.count; index++) {
        let p = corners[index];
        let q = corners[select(index + 1u, 0u, index + 1u == polygon.count)];
        let normal = cross3(p, q);
        sum += dot3(up, normal) * angle_over_sine(sqrt(dot3(normal, normal)), dot3(p, q));
    }
    return 0.5 * sum;
}

// Radon's cubature over a triangle, exact to the fifth degree: barycentric weights of the corners, and the
// weight of the point.
const RADON: array<vec4<f32>, 7> = array(
    vec4(0.333333333, 0.333333333, 0.333333333, 0.225),
    vec4(0.797426985, 0.101286507, 0.101286507, 0.125939181),
    vec4(0.101286507, 0.797426985, 0.101286507, 0.125939181),
    vec4(0.101286507, 0.101286507, 0.797426985, 0.125939181),
    vec4(0.059715872, 0.470142064, 0.470142064, 0.132394153),
    vec4(0.470142064, 0.059715872, 0.470142064, 0.132394153),
    vec4(0.470142064, 0.470142064, 0.059715872, 0.132394153),
);

// Most pieces along a side of a triangle.
const PIECES: u32 = 8u;

fn cubature(polygon: Polygon, up: vec3<f32>, towards: vec3<f32>) -> f32 {
    var corners = polygon.corners;
    var sum = 0.0;
    for (var index = 2u; index < polygon.count; index++) {
        sum += triangle_integral(corners[0], corners[index - 1u], corners[index], up, towards);
    }
    return sum;
}

fn triangle_integral(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, up: vec3<f32>, towards: vec3<f32>) -> f32 {
    let u = b - a;
    let v = c - a;
    let cross = cross3(u, v);
    let area = 0.5 * sqrt(dot3(cross, cross));
    let longest = sqrt(max(max(dot3(u, u), dot3(v, v)), dot3(c - b, c - b)));
    // Lower bound on the distance of the corners; pieces are at most a quarter of it.
    let distance = abs(dot3(towards, a));
    let near = max(distance, sqrt(min(min(dot3(a, a), dot3(b, b)), dot3(c, c))) - longest);
    let pieces = clamp(u32(min(4.0 * longest / max(near, 1e-30), 1000.0)) + 1u, 1u, PIECES);
    let size = 1.0 / f32(pieces);
    var points = RADON;
    var sum = 0.0;
    for (var row = 0u; row < pieces; row++) {
        // Upright pieces and, between them, inverted ones.
        for (var piece = 0u; piece < 2u * (pieces - row) - 1u; piece++) {
            let down = (piece & 1u) == 1u;
            let base = vec2(f32((piece + 1u) / 2u), f32(row + (piece & 1u))) * size;
            let turn = select(size, -size, down);
            for (var point = 0u; point < 7u; point++) {
                let weights = points[point];
                let at = a + u * (base.x + turn * weights.y) + v * (base.y + turn * weights.z);
                sum += weights.w * geometry_term(at, up, towards);
            }
        }
    }
    return sum * area * size * size;
}

// Corners of the polygon that stands for an ellipse, the cosine and sine of the angle between them, and the factor that gives it the
// ellipse's area.
const ELLIPSE_CORNERS: u32 = 64u;
const ELLIPSE_TURN: vec2<f32> = vec2(0.99518472667, 0.09801714033);
const ELLIPSE_SIZE: f32 = 1.00080377;

// Corners of the visible part of an outline so far, and the integral over it.
struct Walk {
    first: vec3<f32>,
    last: vec3<f32>,
    count: u32,
    sum: f32,
}

fn add_corner(walk: Walk, corner: vec3<f32>, up: vec3<f32>, towards: vec3<f32>, far: bool) -> Walk {
    var next = walk;
    if walk.count == 0u {
        next.first = corner;
    } else if !far {
        next.sum += edge_integral(walk.last, corner, up);
    } else if walk.count > 1u {
        next.sum += triangle_integral(walk.first, walk.last, corner, up, towards);
    }
    next.last = corner;
    next.count += 1u;
    return next;
}

fn edge_integral(p: vec3<f32>, q: vec3<f32>, up: vec3<f32>) -> f32 {
    let normal = cross3(p, q);
    return 0.5 * dot3(up, normal) * angle_over_sine(sqrt(dot3(normal, normal)), dot3(p, q));
}

// Irradiance per unit radiance of a light that is no parallelogram.
fn unshadowed_outline(origin: vec3<f32>, up: vec3<f32>, towards: vec3<f32>) -> f32 {
    let away = from_light(origin);
    let far = dot3(away, away) > light_shorter_squared() * 64.0;
    let count = select(frame.outline.x, ELLIPSE_CORNERS, frame.outline.x == ELLIPSE);
    let seen = frame.light_corner - origin;
    let middle = seen + 0.5 * (frame.light_u + frame.light_v);
    var turn = vec2(ELLIPSE_SIZE, 0.0);
    var walk = Walk(vec3(0.0), vec3(0.0), 0u, 0.0);
    var before = vec3(0.0);
    for (var index = 0u; index <= count; index++) {
        var corner = middle + 0.5 * (frame.light_u * turn.x + frame.light_v * turn.y);
        if frame.outline.x != ELLIPSE {
            corner = seen + frame.outline_corners[select(index, 0u, index == count)].xyz;
        }
        turn = vec2(
            turn.x * ELLIPSE_TURN.x - turn.y * ELLIPSE_TURN.y,
            turn.x * ELLIPSE_TURN.y + turn.y * ELLIPSE_TURN.x,
        );
        let height = dot3(up, corner);
        if index > 0u {
            let low = dot3(up, before);
            if (low > 0.0 && height < 0.0) || (low < 0.0 && height > 0.0) {
                let crossing = before + (corner - before) * (low / (low - height));
                walk = add_corner(walk, crossing, up, towards, far);
            }
        }
        if height >= 0.0 && index < count {
            walk = add_corner(walk, corner, up, towards, far);
        }
        before = corner;
    }
    if walk.count < 3u {
        return 0.0;
    }
    if far {
        return max(walk.sum, 0.0);
    }
    let sign = select(1.0, -1.0, light_side(origin) > 0.0);
    return max((walk.sum + edge_integral(walk.last, walk.first, up)) * sign, 0.0);
}

// Irradiance per unit radiance of a sphere, with the receiver's horizon (halflight-cpu/src/unshadowed/sphere.rs).
fn unshadowed_sphere(origin: vec3<f32>, up: vec3<f32>) -> f32 {
    let radius = sphere().w;
    let to = sphere().xyz - origin;
    let far = length3(to);
    let height = dot3(up, to);
    if far <= radius {
        return PI;
    }
    let sine = (radius / far) * (radius / far);
    let cosine = height / far;
    if height >= radius {
        return PI * sine * cosine;
    }
    if height <= -radius {
        return 0.0;
    }
    let x = sqrt((far - radius) * (far + radius)) / radius;
    let turned = sqrt(max(1.0 - cosine * cosine, 1e-12));
    let y = clamp(-x * cosine / turned, -1.0, 1.0);
    let span = sqrt(max((1.0 - y) * (1.0 + y), 0.0));
    let arc = angle_over_sine(span, y) * span;
    let part = height / radius;
    let z = sqrt(max((1.0 - part) * (1.0 + part), 0.0)) / x;
    var rim = angle_over_sine(z, 1.0) * z - x * x * z * sine;
    if z < 0.2 {
        // z s² − (z − atan z), where the last two terms cancel.
        let square = z * z;
        rim = z * sine - z * square
            * (1.0 / 3.0 - square * (1.0 / 5.0 - square * (1.0 / 7.0 - square * (1.0 / 9.0 - square / 11.0))));
    }
    return max(sine * cosine * arc + rim, 0.0);
}

// Irradiance per unit radiance at a receiver.
fn unshadowed(origin: vec3<f32>, up: vec3<f32>) -> f32 {
    if is_sphere() {
        return unshadowed_sphere(origin, up);
    }
    let towards = facing(origin);
    if all(towards == vec3(0.0)) {
        return 0.0;
    }
    if frame.outline.x != PARALLELOGRAM {
        return unshadowed_outline(origin, up, towards);
    }
    let polygon = visible_polygon(origin, up);
    if polygon.count < 3u {
        return 0.0;
    }
    let away = from_light(origin);
    if dot3(away, away) > light_shorter_squared() * 64.0 {
        return max(cubature(polygon, up, towards), 0.0);
    }
    // Seen from in front, the corners run clockwise: the sum is negative there.
    let sign = select(1.0, -1.0, light_side(origin) > 0.0);
    return max(lambert(polygon, up) * sign, 0.0);
}
