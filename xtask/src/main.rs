//! Halflight.
fn main() {}
