//! Results against closed forms and independent integration.

#![allow(clippy::unwrap_used)]

mod emissive_faces;
mod flush_lights;
mod glossy;
mod half_plane;
mod indirect;
mod light_shapes;
mod open_floor;
mod smooth_sphere;
mod sphere_lights;
mod textured_lights;
mod unshadowed;
mod visible_lights;
