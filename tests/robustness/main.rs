//! Sizes, threads, convergence and places where methods fail.

#![allow(clippy::unwrap_used)]

mod convergence;
mod determinism;
mod image_hashes;
mod placement;
mod sizes;
mod thin_shadows;
