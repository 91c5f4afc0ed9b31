//! Tests without a device: every permutation of the shaders is valid, both sides agree on layouts, and modules have an order.

mod imports;
mod layouts;
mod permutations;
