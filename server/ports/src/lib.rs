//! Interfaces between the parts of the server that have more than one implementation or user.
//!
//! - [`RobotLink`]: the simulator, a replay and, later, real robots on one side, the runtime on the other;
//! - [`Journal`]: the recorder on one side, the runtime on the other;
//! - [`MapImporter`]: the program that imports point clouds on one side, the runtime on the other;
//! - [`DataDir`]: the layout of the data directory, for the store that writes and the gateway that reads.

mod data_dir;
mod journal;
mod map_importer;
mod robot_link;

pub use api::SimulatedFault;
pub use data_dir::DataDir;
pub use journal::{Journal, JournalError};
pub use map_importer::MapImporter;
pub use robot_link::{Arrival, LinkError, RobotEvent, RobotLink};
