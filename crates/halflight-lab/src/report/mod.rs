//! Files that an experiment ends in: `results.csv`, tables, charts and `report.html`.

mod columns;
mod figure;
mod front;
mod html;
mod output;
mod page;

pub use html::{page, table};
pub use output::write;
