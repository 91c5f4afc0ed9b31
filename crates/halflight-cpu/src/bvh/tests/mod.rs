//! Bundles against single rays against brute force, on made-up meshes.

mod agreement;
mod meshes;
