//! Upsamplers: fragments to one value a pixel.
