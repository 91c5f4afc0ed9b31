// Counts triangles by cell, per triangle. A triangle lies in the cells that its rectangle covers in the
// finest framebuffer in which these are at most two per side: at most four cells, which bounds the memory.
//@ needs visibility/raster4d_bounds visibility/raster4d_cells
//@ reads triangles
//@ writes bins rectangles

@compute @workgroup_size(64)
fn count_triangles(here: Lane) {
    let triangle = invocation(here);
    if triangle >= TRIANGLES {
        return;
    }
    for (var side = 0u; side < frame.sides; side++) {
        let rectangle = triangle_rectangle(triangle, side);
        let number = side * TRIANGLES + triangle;
        rectangles[number] = vec4(rectangle.low, rectangle.high);
        var cells = NONE;
        if rectangle.low.x <= rectangle.high.x {
            cells = cells_under(rectangle, side);
            for (var corner = 0u; corner < 4u; corner++) {
                let cell = cell_at_corner(cells, corner, side);
                if cell != NONE {
                    atomicAdd(&bins[TRIANGLE_ENDS + cell], 1u);
                }
            }
        }
        atomicStore(&bins[cells_of_triangles() + number], cells);
    }
}

fn cells_under(rectangle: Rectangle, side: u32) -> u32 {
    let around = bounds(side);
    // More than the rounding error of a receiver's position.
    let low = cell_at(squeezed(rectangle.low) - 1e-6, around);
    let high = cell_at(squeezed(rectangle.high) + 1e-6, around);
    var level = 0u;
    while any((high >> vec2(level)) - (low >> vec2(level)) > vec2(1u)) {
        level++;
    }
    return packed_cells(level, low >> vec2(level), high >> vec2(level));
}

// Rectangle around a triangle, rounded outwards; empty where the triangle lies behind the light.
fn triangle_rectangle(triangle: u32, side: u32) -> Rectangle {
    var low = vec2(UNBOUNDED);
    var high = vec2(-UNBOUNDED);
    // Bounds on the positions of its corners, and its greatest height.
    var least = vec2(UNBOUNDED);
    var most = vec2(-UNBOUNDED);
    var highest = -UNBOUNDED;
    var is_near = false;
    let near = 64.0 * thickness();
    for (var corner = 0u; corner < 3u; corner++) {
        let p = local(triangles[3u * triangle + corner].xyz, side);
        least = min(least, p.at - p.at_error);
        most = max(most, p.at + p.at_error);
        highest = max(highest, p.height + p.height_error);
        if p.height < max(near, 64.0 * p.height_error) {
            is_near = true;
        } else {
            let error = slope_error(p);
            low = min(low, min(slope(p, 1.0 + MARGIN), slope(p, -MARGIN)) - error);
            high = max(high, max(slope(p, 1.0 + MARGIN), slope(p, -MARGIN)) + error);
        }
    }
    if highest < -thickness() {
        return Rectangle(vec2(UNBOUNDED), vec2(-UNBOUNDED));
    }
    if is_near {
        // At the light's plane slopes are unbounded, except on a side where all of the triangle lies beside
        // the light.
        let reach = max(highest, near);
        let right = (least - (1.0 + 2.0 * MARGIN)) / reach;
        let left = (most + 2.0 * MARGIN) / reach;
        low = select(vec2(-UNBOUNDED), right * 0.9999, right > vec2(0.0));
        high = select(vec2(UNBOUNDED), left * 0.9999, left < vec2(0.0));
    }
    return Rectangle(low, high);
}
