// Cells as upsamplers meet them: found by pixel, with their samples.

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

// Samples that a cell may have beyond the one that stands for it.
fn further_count(owner: Owner) -> u32 {
    return select(0u, 3u, cells[owner_place(owner)].kept == KEPT_MORE);
}

// The pixel of one of them, which is its place as well; NONE where it does not exist.
fn further_place(owner: Owner, number: u32) -> u32 {
    let half = 1u << (owner.level - 1u);
    let at = (owner.cell << vec2(owner.level)) + half * vec2(number & 1u, number >> 1u);
    if at.x >= frame.width || at.y >= frame.height || !is_receiver(at.y * frame.width + at.x) {
        return NONE;
    }
    return at.y * frame.width + at.x;
}
