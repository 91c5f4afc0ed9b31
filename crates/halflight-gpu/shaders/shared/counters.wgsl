// Places in `counters`. Those from TALLY on are spread over BUCKETS each, so that workgroups do not queue up at one address.
//@ writes counters

// Cells that have asked so far.
const QUERIES: u32 = 0u;
// The queries at hand: the first, and the one after the last.
const FIRST: u32 = 1u;
const END: u32 = 2u;
// Coarsest level of any cell that was kept.
const TOP: u32 = 3u;
// Queries that found no room.
const OVERFLOW: u32 = 4u;
// Floats, by their bits: expected squared error, and the image's square.
const EXPECTED: u32 = 5u;
const ENERGY: u32 = 6u;
// Cells that wait to be looked at, and pixels that see something.
const CELLS_LEFT: u32 = 7u;
const PIXELS_SEEN: u32 = 8u;
const TALLY: u32 = 16u;
const BUCKETS: u32 = 64u;
// Kinds of tallies: traced to refine, traced for irradiance alone, skipped; samples of each level, cells of each level.
const SKIPPED: u32 = 2u;
const SAMPLES_PER_LEVEL: u32 = 3u;
const CELLS_PER_LEVEL: u32 = 11u;
