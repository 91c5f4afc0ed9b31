//! Packets against single rays against brute force, on synthetic meshes.

mod agreement;
mod building;
pub(crate) mod meshes;
mod refit;
mod watertight;
