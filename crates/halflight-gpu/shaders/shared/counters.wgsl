// Indices in `counters`. Those from TALLY on have BUCKETS words each, so that workgroups do not contend for
// one address.
//@ writes counters

// Number of cells that have requested masks so far.
const QUERIES: u32 = 0u;
// Current batch of queries: index of the first, and one past the last.
const FIRST: u32 = 1u;
const END: u32 = 2u;
// Coarsest level of any cell that was kept.
const TOP: u32 = 3u;
// Number of queries that did not fit.
const OVERFLOW: u32 = 4u;
// Floats, as their bits: estimated squared error, and squared luminance of the image.
const EXPECTED: u32 = 5u;
const ENERGY: u32 = 6u;
// Number of pending cells, and of pixels that see geometry.
const CELLS_LEFT: u32 = 7u;
const PIXELS_SEEN: u32 = 8u;
const TALLY: u32 = 16u;
const BUCKETS: u32 = 64u;
// Kinds of tallies: rays traced to refine, rays traced for irradiance alone, rays skipped; samples of each
// level, cells of each level.
const SKIPPED: u32 = 2u;
const SAMPLES_PER_LEVEL: u32 = 3u;
const CELLS_PER_LEVEL: u32 = 11u;
// Rays of specular lobes.
const LOBE_RAYS: u32 = 19u;
