//! Halflight.
