//! Charts of rows, as SVG and PNG.

mod axis;
mod bars;
mod canvas;
mod chart;
mod draw;
mod drawing;
pub mod equal_error;
pub mod errors;
pub mod expected;
pub mod families;
pub mod flicker;
pub mod indirect;
mod key;
mod layout;
mod marks;
pub mod path;
pub mod scaling;
mod shape;
pub mod sweep;

pub use bars::{Bar, Bars};
pub use chart::{Chart, KeyGroup, Mark, Point, Scale, Series, Shape};
pub use drawing::Drawing;
pub use layout::Layout;
