// Emission of the strata of a textured light's samples (halflight-cpu/src/textured/strata.rs): radiance, and the
// mean of the sum of squares of red, green and blue.
//@ reads emitted

// Fewest columns of patterns that the device chooses.
const FEWEST: u32 = 4u;

// Index of the first stratum of the pattern. Patterns that a device chooses are squares, stored by their number of
// columns.
fn strata_first() -> u32 {
    if frame.texture.z == 0u {
        return frame.texture.y;
    }
    return frame.texture.y + squares_below(frame.pattern.columns) - squares_below(FEWEST);
}

// Sum of the squares of all numbers below one.
fn squares_below(number: u32) -> u32 {
    return (number - 1u) * number * (2u * number - 1u) / 6u;
}
