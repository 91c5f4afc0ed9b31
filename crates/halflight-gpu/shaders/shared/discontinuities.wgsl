// Discontinuities between neighbouring pixels (halflight-cpu/src/refine/discontinuities.rs): a word for every cell, level by level, of these bits.

// Something lies between the pixel and its right neighbour, or the one below.
const RIGHT: u32 = 1u;
const BELOW: u32 = 2u;
// How far these are shifted where the two may shade each other.
const SHADE: u32 = 2u;

// What cells hold.
const NOTHING: u32 = 0u;
const STEP: u32 = 1u;
const SHADES: u32 = 2u;
