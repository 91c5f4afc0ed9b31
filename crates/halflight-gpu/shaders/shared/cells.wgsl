// What is known of a cell, level by level.
//@ reads cells

struct Cell {
    state: u32,
    // Its query, or NONE.
    slot: u32,
    // Whether it is part of the image, and with which samples.
    kept: u32,
    // Whether its neighbourhood showed a discontinuity.
    flag: u32,
}

// Of `state`: to be looked at; the same, and to be rendered whatever its geometry; rendered; a pixel that is an additional sample;
// waiting for masks at its corners; looked at.
const PENDING: u32 = 1u;
const FORCED: u32 = 2u;
const RENDERED: u32 = 3u;
const ADDITIONAL: u32 = 4u;
const WAITING: u32 = 5u;
const DONE: u32 = 6u;

// Of `kept`: its samples are one, or its corners; or one, and additional ones at its first pixel and those right of and below
// its middle.
const KEPT: u32 = 1u;
const KEPT_MORE: u32 = 2u;

// The cell of a number within the level at hand.
fn cell_of(number: u32) -> vec2<u32> {
    let columns = level_size(frame.level).x;
    return vec2(number % columns, number / columns);
}
