//! Shaders without a device: every permutation is valid, and both sides agree on layouts.

mod layouts;
mod permutations;
