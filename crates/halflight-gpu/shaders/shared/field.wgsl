// Cells as upsamplers meet them: found by pixel, with their samples.
//@ reads owners

// A rectangle of pixels, ends excluded.
struct Rect {
    first: vec2<u32>,
    last: vec2<u32>,
}

struct Owner {
    level: u32,
    cell: vec2<u32>,
}

// The cell that a pixel lies in; its level is NONE where there is none.
fn owner_at(at: vec2<u32>) -> Owner {
    let level = owners[at.y * frame.width + at.x];
    return Owner(level, at >> vec2(level & 31u));
}

fn owner_rect(owner: Owner) -> Rect {
    let first = owner.cell << vec2(owner.level);
    return Rect(first, min(first + (1u << owner.level), vec2(frame.width, frame.height)));
}

fn owner_place(owner: Owner) -> u32 {
    return cell_index(owner.level, owner.cell);
}
