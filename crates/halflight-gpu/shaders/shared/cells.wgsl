// State of cells, level by level.
//@ reads cells

struct Cell {
    state: u32,
    // Query of the cell, or NONE.
    slot: u32,
    // Kind of samples if the cell is part of the image, else 0.
    kept: u32,
    // 1 if the cell's neighbourhood has an illumination discontinuity.
    flag: u32,
}

// Values of `state`: to be processed; to be processed, and rendered whatever its geometry; rendered; a pixel
// that is an additional sample; waiting for masks at its corners; processed.
const PENDING: u32 = 1u;
const FORCED: u32 = 2u;
const RENDERED: u32 = 3u;
const ADDITIONAL: u32 = 4u;
const WAITING: u32 = 5u;
const DONE: u32 = 6u;

// Values of `kept`: with one sample, or its corners; with one sample and additional ones at its first pixel
// and those right of and below its centre.
const KEPT: u32 = 1u;
const KEPT_MORE: u32 = 2u;

// Cell with a linear index within the current level.
fn cell_of(number: u32) -> vec2<u32> {
    let columns = level_size(frame.level).x;
    return vec2(number % columns, number / columns);
}
