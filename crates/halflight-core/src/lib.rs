//! Types, light sampling, masks and the three stage traits of Halflight.
//!
//! The crate does no IO and starts no thread. A frame's data flows through its modules in this order: [`scene`] and
//! [`light`] are seen in the [`gbuffer`], whose breaks the [`pyramid`] holds; a refiner ([`stages`]) asks for light
//! [`mask`]s over a [`pattern`] of light samples and hands on [`fragment`]s, whose samples have [`values`]; [`stats`] come back
//! with the image.

pub mod alpha;
pub mod camera;
pub mod certificate;
pub mod fragment;
pub mod frame;
pub mod gbuffer;
pub mod hash;
pub mod light;
pub mod light_texture;
pub mod limits;
pub mod mask;
pub mod pattern;
pub mod pyramid;
pub mod scene;
pub mod smooth;
pub mod specular;
pub mod stages;
pub mod stats;
pub mod subpixel;
pub mod values;

pub use glam;
