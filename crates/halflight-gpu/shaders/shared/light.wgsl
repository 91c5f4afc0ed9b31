// Light samples and what they add, as in halflight-cpu/src/samples.rs.
//@ needs shared/hash

const GRID: u32 = 0u;
const SHIFTED_ROWS: u32 = 1u;

fn unit_pair(bits: u32) -> vec2<f32> {
    return (vec2(f32(bits >> 16u), f32(bits & 0xffffu)) + 0.5) * (1.0 / 65536.0);
}

// Place of a sample in the unit square.
fn sample_place(index: u32, key: u32) -> vec2<f32> {
    let column = index % frame.pattern.columns;
    let row = index / frame.pattern.columns;
    var inside = vec2(0.5);
    if frame.pattern.kind == SHIFTED_ROWS {
        inside = unit_pair(sample_bits(key, row));
    } else if frame.pattern.kind != GRID {
        inside = unit_pair(sample_bits(key, index));
    }
    return (vec2(f32(column), f32(row)) + inside) * frame.pattern.scale;
}

fn sample_point(index: u32, key: u32) -> vec3<f32> {
    let place = sample_place(index, key);
    return frame.light_corner + frame.light_u * place.x + frame.light_v * place.y;
}

// The light's unit normal on the side of a point; zero where no light leaves towards it.
fn facing(origin: vec3<f32>) -> vec3<f32> {
    let between = origin - frame.light_corner;
    let side = dot3(frame.light_cross, between);
    if side == 0.0 || (side < 0.0 && frame.two_sided == 0u) {
        return vec3(0.0);
    }
    return select(frame.light_normal, -frame.light_normal, dot3(frame.light_normal, between) < 0.0);
}

// Geometry term of a sample at `d` from the receiver, 0 below either horizon.
fn geometry_term(d: vec3<f32>, normal: vec3<f32>, towards: vec3<f32>) -> f32 {
    let receiver = max(dot3(d, normal), 0.0);
    let emitter = max(dot3(d, -towards), 0.0);
    let squared = dot3(d, d);
    // 0/0 where the receiver lies on the sample itself.
    if squared <= 0.0 {
        return 0.0;
    }
    return receiver * emitter / (squared * squared);
}

// How many of the light's corners are above a receiver's horizon.
fn corners_above(origin: vec3<f32>, normal: vec3<f32>) -> u32 {
    let a = frame.light_corner;
    let b = a + frame.light_u;
    let c = a + frame.light_u + frame.light_v;
    let d = a + frame.light_v;
    return u32(dot3(normal, a - origin) > 0.0) + u32(dot3(normal, b - origin) > 0.0)
        + u32(dot3(normal, c - origin) > 0.0) + u32(dot3(normal, d - origin) > 0.0);
}
