//! Packets against single rays against brute force, on made-up meshes.

mod agreement;
mod building;
pub(crate) mod meshes;
mod refit;
mod watertight;
