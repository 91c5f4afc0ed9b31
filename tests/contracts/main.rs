//! Extension contracts: external stages, partial queries, shared samples, typed refusals, reused buffers.

#![allow(clippy::unwrap_used)]

mod backends;
mod corners;
#[allow(dead_code, unreachable_pub)]
#[path = "../../crates/halflight/examples/custom_stages.rs"]
mod custom_stages;
mod grids_only;
mod moving;
mod packets;
mod refusals;

#[test]
fn the_example_runs() {
    let summary = custom_stages::run().unwrap();
    assert!(summary.contains(" fragments, ") && !summary.contains("mean irradiance 0.000"), "{summary}");
    assert!(summary.contains("masks are one word here"), "{summary}");
}
