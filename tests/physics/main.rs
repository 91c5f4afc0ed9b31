//! Results against closed forms and independent integration.

#![allow(clippy::unwrap_used)]

mod flush_lights;
mod half_plane;
mod open_floor;
mod smooth_sphere;
mod textured_lights;
mod unshadowed;
