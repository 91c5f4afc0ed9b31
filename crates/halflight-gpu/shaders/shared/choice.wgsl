// What a trial of receivers has chosen for an error target. Its twin is `Choice` in refine/target.rs; it is copied into the
// uniforms of the levels.
//@ writes chosen

struct Choice {
    pattern: Pattern,
    error: f32,
    // The coarsest level of cells: 0 where every pixel is traced.
    coarsest: u32,
    // What would be taken for every pixel; no samples where that is never done.
    every: Pattern,
}
