// What a trial of receivers has chosen for an error target. Its twin is `Choice` in refine/target.rs; it is copied into the
// uniforms of the levels.
//@ writes chosen

struct Choice {
    pattern: Pattern,
    error: f32,
    step_level: u32,
}
