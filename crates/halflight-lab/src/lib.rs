//! Research toolkit: references, and experiments from a file to a report.
//!
//! Data of an experiment flow one way: [`experiment`] says what is varied, [`run`] renders and measures it, [`results`] are
//! the rows, [`analysis`] compares rows, [`plot`] draws charts of them and [`report`] writes the page. Beside them stand the
//! robustness suite, the exactness suite and the experiment on furnished scenes; [`rivals`] and [`phong`] are methods from elsewhere.

pub mod analysis;
pub mod exactness;
pub mod experiment;
pub mod furnished;
pub mod phong;
pub mod plot;
pub mod program;
pub mod reference;
pub mod report;
pub mod results;
pub mod rivals;
pub mod robustness;
pub mod run;
