// Writes pixels, per pixel: those of fine cells copy their cell's value, the others call `value_at`.
//@ needs shared/field shared/query shared/surface
//@ reads samples
//@ writes plane

// Coarsest level of cells whose value is copied.
override COPIED_LEVEL: u32 = 0u;

@compute @workgroup_size(8, 8)
fn pixels(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= frame.width || at.y >= frame.height {
        return;
    }
    let pixel = at.y * frame.width + at.x;
    let owner = owner_at(at.xy);
    if owner.level == NONE || !is_receiver(pixel) {
        plane[pixel] = 0.0;
    } else if owner.level <= COPIED_LEVEL {
        // An undefined value means that the light is below the horizon: the pixel is 0.
        plane[pixel] = max(samples[owner_place(owner)].value, 0.0);
    } else {
        plane[pixel] = value_at(at.xy, owner);
    }
}
