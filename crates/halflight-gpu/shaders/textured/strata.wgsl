// Emission of the strata of a textured light's samples (halflight-cpu/src/textured/strata.rs): radiance, and the
// mean of the sum of squares of red, green and blue.
//@ reads emitted

// Number of strata of all patterns of fewer columns that the error target may choose, if there were any from 1
// on: Σ k² below 4.
const SKIPPED_STRATA: u32 = 14u;

// Index of the first stratum of the pattern. Patterns that a device chooses are squares, stored by their number of
// columns.
fn strata_first() -> u32 {
    if frame.texture.z == 0u {
        return frame.texture.y;
    }
    let columns = frame.pattern.columns;
    return frame.texture.y + (columns - 1u) * columns * (2u * columns - 1u) / 6u - SKIPPED_STRATA;
}
