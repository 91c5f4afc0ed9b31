//! Against closed forms and independent integration.

#![allow(clippy::unwrap_used)]

mod half_plane;
mod open_floor;
mod unshadowed;
