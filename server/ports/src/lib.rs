//! Interfaces between the parts of the server that have more than one implementation or user.
//!
//! - [`RobotLink`]: the simulator, a replay and, later, real robots on one side, the runtime on the other;
//! - [`ActionServer`]: robots and other programs that perform actions on one side, the runtime on the other;
//! - [`Journal`] and [`SegmentWriter`]: the recorder on one side, the runtime on the other;
//! - [`MapImporter`]: the program that imports point clouds on one side, the runtime on the other;
//! - [`ChangeFinder`]: the program that compares visits on one side, the runtime on the other;
//! - [`GaugeReader`]: the program that reads gauges in pictures on one side, the runtime on the other;
//! - [`PictureComparer`]: the program that compares pictures on one side, the runtime on the other;
//! - [`ExampleMaker`]: the program that makes a site to try on one side, the runtime on the other;
//! - [`encode_frame`], [`read_frame`]: messages on the Unix sockets between processes;
//! - [`DataDir`]: the layout of the data directory, for the store that writes and the gateway that reads;
//! - [`error_with_causes`]: an error as a text for people, for all parts that report errors.

mod action_server;
mod change_finder;
mod data_dir;
mod error_text;
mod example_maker;
mod frames;
mod gauge_reader;
mod journal;
mod map_importer;
mod picture_comparer;
mod robot_link;
mod texts;

pub use action_server::{
    ActionCall, ActionEnd, ActionEvent, ActionFile, ActionRegistration, ActionServer,
    MAX_ACTION_PARAMETER_BYTES, MAX_ACTION_RESULT_BYTES, MAX_OPEN_ACTIONS,
};
pub use api::SimulatedFault;
pub use change_finder::{ChangeFinder, FoundChange, FoundChanges};
pub use data_dir::DataDir;
pub use error_text::error_with_causes;
pub use example_maker::{ExampleMaker, ExampleRequest};
pub use frames::{FrameError, encode_frame, read_frame};
pub use gauge_reader::{GaugeReader, ReadGauge};
pub use journal::{Journal, JournalError, Segment, SegmentWriter};
pub use map_importer::MapImporter;
pub use picture_comparer::{ComparedPicture, PictureComparer};
pub use robot_link::{Arrival, LinkError, RobotEvent, RobotLink};
pub use texts::REAL_ROBOT_HAS_NO_FAULTS;
