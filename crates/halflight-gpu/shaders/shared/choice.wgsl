// Sampling plan that the pilot samples give for an error target. The twin of this struct is `Choice` in
// refine/target.rs; it is copied into the uniforms of the levels.
//@ writes chosen

struct Choice {
    pattern: Pattern,
    error: f32,
    // Coarsest level of cells: 0 if every pixel is traced.
    coarsest: u32,
    // Pattern if every pixel is traced; no samples if that never happens.
    every: Pattern,
}
