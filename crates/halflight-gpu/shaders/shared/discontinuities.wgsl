// Flags of discontinuities between neighbouring pixels (halflight-cpu/src/refine/discontinuities.rs): one
// word per cell, level by level.

// Discontinuity between the pixel and its right neighbour, or the one below.
const RIGHT: u32 = 1u;
const BELOW: u32 = 2u;
// Shift of these bits for discontinuities where one surface may shadow the other.
const SHADE: u32 = 2u;

// Strongest discontinuity of a cell: none, without and with a possible contact shadow.
const NOTHING: u32 = 0u;
const STEP: u32 = 1u;
const SHADES: u32 = 2u;
