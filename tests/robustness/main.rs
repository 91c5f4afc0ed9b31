//! Robustness suite: sizes, threads, convergence and difficult scenes.

#![allow(clippy::unwrap_used)]

mod convergence;
mod determinism;
mod image_hashes;
mod placement;
mod quality;
mod sizes;
mod thin_shadows;
