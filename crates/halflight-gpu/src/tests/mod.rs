//! Tests without a device: every permutation of the shaders is valid, and both sides agree on layouts.

mod layouts;
mod permutations;
