//! Rows of a run: records, their CSV files, the names of their pictures, and the program and machine that they come from.

mod frames;
pub mod indirect;
mod outcome;
mod pictures;
mod provenance;
pub mod record;
pub mod specular;
pub mod table;

pub use frames::{Along, FrameError, FrameWork, Means};
pub use indirect::IndirectRow;
pub use outcome::Outcome;
pub use pictures::{PictureKind, WINDOW, pictures};
pub use provenance::{Provenance, hash};
pub use record::{Finished, PaperError, Record};
pub use specular::SpecularRow;
pub use table::{Line, Table};
