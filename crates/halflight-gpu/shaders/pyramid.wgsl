// Builds one level of the discontinuity pyramid, per pixel on a border between a cell's children: from the
// next finer level and pixel pairs across these borders to the largest discontinuity
// (halflight-cpu/src/pyramid.rs). The maximum does not depend on the order of invocations.
//@ needs shared/pyramid shared/surface
//@ reads position

@compute @workgroup_size(64)
fn level(here: Lane) {
    let size = 1u << frame.level;
    let number = invocation(here);
    let along = number % (2u * size);
    let columns = level_size(frame.level).x;
    let cell = vec2(number / (2u * size) % columns, number / (2u * size) / columns);
    if cell.y >= level_size(frame.level).y {
        return;
    }
    let index = cell_index(frame.level, cell);
    if along < 4u {
        add_child(index, 2u * cell + vec2(along & 1u, along >> 1u));
    }
    let first = cell * size;
    let last = min(first + size, vec2(frame.width, frame.height));
    let half = size / 2u;
    // Along the vertical border first, then along the horizontal one.
    var at = first + vec2(half - 1u, along);
    var crosses = first.x + half < last.x && at.y < last.y;
    if along >= size {
        at = first + vec2(along - size, half - 1u);
        crosses = first.y + half < last.y && at.x < last.x;
    }
    if !crosses {
        return;
    }
    let pixel = at.y * frame.width + at.x;
    var squared = vec2(0.0);
    if at.x + 1u < last.x {
        squared += pair(pixel, pixel + 1u);
    }
    if at.y + 1u < last.y {
        squared += pair(pixel, pixel + frame.width);
    }
    let depth = select(sqrt(squared.x), ENDLESS, squared.x >= ENDLESS);
    // Cells without receivers keep 0.
    if squared.x > 0.0 {
        atomicMax(&pyramid[2u * index], bitcast<u32>(depth) + 1u);
    }
    atomicMax(&pyramid[2u * index + 1u], bitcast<u32>(sqrt(squared.y)));
}

fn add_child(index: u32, child: vec2<u32>) {
    if any(child >= level_size(frame.level - 1u)) {
        return;
    }
    if frame.level == 1u {
        if is_receiver(child.y * frame.width + child.x) {
            atomicMax(&pyramid[2u * index], 1u);
        }
        return;
    }
    let finer = cell_index(frame.level - 1u, child);
    atomicMax(&pyramid[2u * index], atomicLoad(&pyramid[2u * finer]));
    atomicMax(&pyramid[2u * index + 1u], atomicLoad(&pyramid[2u * finer + 1u]));
}

// Squared discontinuity between two neighbouring pixels: depth difference relative to the nearer one, and the
// chord between the normals.
fn pair(a: u32, b: u32) -> vec2<f32> {
    let depths = vec2(position[a].w, position[b].w);
    if depths.x < 0.0 && depths.y < 0.0 {
        return vec2(0.0);
    }
    if depths.x < 0.0 || depths.y < 0.0 {
        return vec2(ENDLESS, 0.0);
    }
    let near = min(depths.x, depths.y);
    let step = (max(depths.x, depths.y) - near) / near;
    let turn = normal_at(a) - normal_at(b);
    return vec2(step * step, dot3(turn, turn));
}
