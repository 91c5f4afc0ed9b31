// A textured light, as lobes see it: texels, and their means over squares (halflight-core/src/light_texture/levels.rs).
//@ needs textured/texel

// Bits of the fourth component of the first texel, where those of the others say how far behind it their level begins:
// those of normal numbers.
const NORMAL_BITS: u32 = 0x3f800000u;

fn factors_at(uv: vec2<f32>) -> vec3<f32> {
    return texel_at(uv);
}

// Mean in a square of the unit square, without its parts outside, over three by three squares of texels at most, of
// which it is no more than two wide. There is no loop: Mesa's software devices end the loops of an invocation after 65,535
// steps in all, and lobes beside a screen would reach them.
fn factors_around(uv: vec2<f32>, side: f32) -> vec3<f32> {
    let size = frame.texture_size.xy;
    let extent = vec2<f32>(size);
    let turned = select(uv, uv.yx, frame.texture_size.z == 1u);
    let begin = clamp(turned - 0.5 * side, vec2(0.0), vec2(1.0));
    let end = clamp(turned + 0.5 * side, vec2(0.0), vec2(1.0));
    let low = vec2(begin.x, 1.0 - end.y) * extent;
    let high = vec2(end.x, 1.0 - begin.y) * extent;
    let level = level_of(side * max(extent.x, extent.y), max(size.x, size.y));
    let first = frame.texture.w - 1u;
    let squares = Squares(
        low,
        high,
        f32(1u << level),
        (size + (1u << level) - 1u) >> vec2(level),
        first + bitcast<u32>(emitted[first + level].w) - NORMAL_BITS,
    );
    let from_square = min(vec2<u32>(low / squares.side), squares.count - 1u);
    let to_square = min(vec2<u32>(high / squares.side), squares.count - 1u);
    if all(from_square == to_square) {
        return emitted[squares.first + from_square.y * squares.count.x + from_square.x].xyz;
    }
    let rows = from_square + vec2(0u, 1u);
    let sum = row_of(squares, from_square) + row_of(squares, rows) + row_of(squares, rows + vec2(0u, 1u));
    if sum.w > 0.0 {
        return sum.xyz / sum.w;
    }
    return emitted[squares.first + from_square.y * squares.count.x + from_square.x].xyz;
}

// Rectangle in texels from the top left, and the squares of a level: side, columns and rows, and place of the first.
struct Squares {
    low: vec2<f32>,
    high: vec2<f32>,
    side: f32,
    count: vec2<u32>,
    first: u32,
}

// Level of which `texels` are two squares at most, of a texture that is `longest` wide or high.
fn level_of(texels: f32, longest: u32) -> u32 {
    let wanted = select(0u, firstLeadingBit(u32(ceil(0.5 * texels)) * 2u - 1u), texels > 2.0);
    return min(wanted, select(0u, firstLeadingBit(2u * longest - 1u), longest > 1u));
}

// Sum over three squares of a row, weighted by their parts in the rectangle, and the sum of these.
fn row_of(squares: Squares, place: vec2<u32>) -> vec4<f32> {
    let right = place + vec2(1u, 0u);
    return square_at(squares, place) + square_at(squares, right) + square_at(squares, right + vec2(1u, 0u));
}

fn square_at(squares: Squares, place: vec2<u32>) -> vec4<f32> {
    let begin = max(squares.low, vec2<f32>(place) * squares.side);
    let end = min(squares.high, vec2<f32>(place + 1u) * squares.side);
    let part = max(end - begin, vec2(0.0));
    // Squares beyond the last have no part.
    let at = min(place, squares.count - 1u);
    return vec4(emitted[squares.first + at.y * squares.count.x + at.x].xyz, 1.0) * (part.x * part.y);
}

fn share_of(reflected: vec3<f32>) -> f32 {
    return luminance(reflected * frame.radiance);
}
