// Rasterizes triangle indices, per pixel: from the scene's triangles to an ID image. All other attributes of
// a pixel follow from its triangle (resolve.wgsl).
//@ reads triangles

struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) triangle: u32,
}

// Distance of the near plane relative to the scene's size. Depth is reversed, so that its precision is
// relative.
const NEAR: f32 = 1e-6;

@vertex
fn corner(@builtin(vertex_index) vertex: u32) -> Corner {
    let point = triangles[vertex].xyz - frame.eye;
    // Coordinates along the pixel axes and along the view direction.
    let right = frame.right * f32(frame.width) * 0.5;
    let down = frame.down * f32(frame.height) * 0.5;
    let z = dot3(point, forward());
    let place = off_centre() / vec2(f32(frame.width) * 0.5, f32(frame.height) * 0.5);
    let x = dot3(point, right) / dot3(right, right) + place.x * z;
    let y = -(dot3(point, down) / dot3(down, down) + place.y * z);
    return Corner(vec4(x, y, frame.scene_size * NEAR, z), vertex / 3u);
}

@fragment
fn fragment(@location(0) @interpolate(flat) triangle: u32) -> @location(0) u32 {
    return triangle;
}
