//! Textured lights: what the strata of a pattern emit, and what receivers would see without occluders.
//!
//! The irradiance of a channel is `L · U · R · F`: `L` is the light's radiance, `U` the unshadowed irradiance of a uniform light, `R` the mean of
//! the texture as the receiver sees it (`seen`), and `F` the visible fraction of the channel (`strata`):
//! `R = Σ_k l_k g_k / Σ_k g_k` over cells of the light with mean `l` and geometry term `g`, and `F = Σ_j l_j g_j V_j / Σ_j l_j g_j` over the
//! strata of the light samples. A uniform texture gives `R = l` and the `F` of a uniform light.

mod seen;
mod strata;

pub use seen::SeenTexture;
pub(crate) use strata::StrataTable;
pub use strata::{ChannelSums, StrataRadiance};
