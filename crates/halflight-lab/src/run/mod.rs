//! Runs of an experiment: rows are rendered, timed in turn and measured against references. A run that was stopped goes on
//! where it was.

mod bench;
mod device;
mod flicker;
mod indirect;
mod loaded;
mod measured;
mod path;
mod progress;
mod runner;
mod specular;
mod state;
mod timing;
mod truth;
mod window;

pub use device::Device;
pub use progress::Progress;
pub use runner::{Places, run};
