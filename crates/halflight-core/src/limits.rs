//! Ranges of coordinates that single precision can work with.

/// Upper bound of coordinates of geometry, lights and cameras, metres: fourth powers of distances are finite in single
/// precision up to forty times as far.
pub const MAX_COORDINATE: f32 = 1e8;

/// The smallest diagonal of a mesh's bounding box, metres: fourth powers of a thirtieth of it are not subnormal.
pub const MIN_DIAGONAL: f32 = 1e-8;

/// Radiance from which on products with it may be infinite in single precision, W/m²/sr.
pub const MAX_RADIANCE: f32 = 1e30;
