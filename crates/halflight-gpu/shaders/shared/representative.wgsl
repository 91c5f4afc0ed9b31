// Representative pixels of cells, and culling of cells that light cannot reach
// (halflight-cpu/src/refine/representative.rs).
//@ needs shared/light shared/query shared/receiver

// Representative pixel of a square: the one right of and below its centre, or else the nearest receiver in
// it. NONE where it has none.
fn fragment_point(corner: vec2<u32>, size: u32) -> u32 {
    let image = vec2(frame.width, frame.height);
    if any(corner >= image) {
        return NONE;
    }
    let centre = min(corner + size / 2u, image - 1u);
    let pixel = centre.y * frame.width + centre.x;
    if is_receiver(pixel) {
        return pixel;
    }
    let last = min(corner + size, image);
    var best = NONE;
    var nearest = NONE;
    for (var y = corner.y; y < last.y; y++) {
        for (var x = corner.x; x < last.x; x++) {
            let other = y * frame.width + x;
            let off = vec2<i32>(vec2(x, y)) - vec2<i32>(centre);
            let distance = u32(off.x * off.x + off.y * off.y);
            if distance < nearest && is_receiver(other) {
                best = other;
                nearest = distance;
            }
        }
    }
    return best;
}

// True if a receiver faces away from all of the light, or the light from it.
fn faces_away(pixel: u32) -> bool {
    if !is_receiver(pixel) {
        return true;
    }
    let receiver = receiver_at(pixel);
    return all(facing(receiver.origin) == vec3(0.0)) || corners_above(receiver.origin, receiver.normal) == 0u;
}

// True if a cell faces away from the light: at its centre and its corners.
fn cell_faces_away(level: u32, cell: vec2<u32>) -> bool {
    let size = 1u << level;
    let first = cell << vec2(level);
    let centre = fragment_point(first, size);
    if centre == NONE || !faces_away(centre) {
        return false;
    }
    let last = min(first + size, vec2(frame.width, frame.height)) - 1u;
    return faces_away(first.y * frame.width + first.x) && faces_away(first.y * frame.width + last.x)
        && faces_away(last.y * frame.width + first.x) && faces_away(last.y * frame.width + last.x);
}

fn pixel_centre(pixel: u32) -> vec2<f32> {
    return vec2(f32(pixel % frame.width), f32(pixel / frame.width)) + 0.5;
}

// Interpolated quantity: 0 irradiance, 1 the visible fraction.
override SHADING: u32 = 1u;

// Sample of a cell that no light can reach: no irradiance, and an undefined fraction.
fn unlit(pixel: u32) -> Sample {
    return Sample(pixel_centre(pixel), select(0.0, NO_VALUE, SHADING == 1u), pixel);
}
