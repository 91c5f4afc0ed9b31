// Places in `counters`. Those from TALLY on are spread over BUCKETS each, so that workgroups do not queue up at one address.

const QUERIES: u32 = 0u;
const OVERFLOW: u32 = 1u;
// Samples of each level, 16.
const PER_LEVEL: u32 = 16u;
const TALLY: u32 = 64u;
const BUCKETS: u32 = 64u;
// Kinds of tallies: traced to refine, traced for irradiance alone, skipped.
const SKIPPED: u32 = 2u;
