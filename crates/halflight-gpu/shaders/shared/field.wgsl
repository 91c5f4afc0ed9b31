// Lookup of cells by pixel, for upsamplers.
//@ reads owners

// Rectangle of pixels, ends excluded.
struct Rect {
    first: vec2<u32>,
    last: vec2<u32>,
}

struct Owner {
    level: u32,
    cell: vec2<u32>,
}

// Cell that contains a pixel; its level is NONE where there is none.
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
