//! State of the operator's client as a reducer: events and commands in, effects out. No egui, no sockets, no clock.
//!
//! [`Model::apply`] is the only way in. Views read the model and emit [`ClientCommand`]s; the shell turns sockets, timers and
//! finished downloads into [`ClientEvent`]s and carries out the [`ClientEffect`]s. Time comes in as [`ClientTime`], randomness as
//! the seed of [`Ids`], so every behaviour of the client can be tested without a browser.

mod align;
mod command;
mod compare;
mod drive;
mod event;
mod history;
mod ids;
mod link;
mod loops;
mod map_view;
mod model;
mod notices;
mod pending;
mod robust_bounds;
mod tiles;
mod time;
mod track;
mod undo;
mod upload;
mod view;

#[cfg(test)]
mod tests;

pub use align::Align;
pub use command::ClientCommand;
pub use compare::{CloudState, ScanComparison, ScanOverlay, fitted, shift};
pub use drive::{Drive, SPEED_MPS_MAX, TELEOPERATION_PERIOD_S, TURN_RADPS_MAX};
pub use event::{CameraMove, ClientEffect, ClientEvent, Socket};
pub use history::LoopEdit;
pub use ids::Ids;
pub use link::{Link, LinkState, Throughput};
pub use loops::{LoopCounts, LoopInitialGuess, LoopPair, LoopPick, LoopProposal, Loops};
pub use map_view::{Loading, MapView};
pub use model::{Model, Robot, Selection};
pub use notices::{NoticeId, Notices, ShownNotice};
pub use pending::PendingCommand;
pub use tiles::{TILE_POINTS_MAX, TILE_REQUESTS_MAX, TileSet, TileState, Viewpoint};
pub use time::{Aged, ClientTime, ServerClock};
pub use track::Trajectory;
pub use undo::{Changed, Undo};
pub use upload::Upload;
pub use view::{Bookmark, CameraPose, ColourBy, Screen, Theme, ViewSettings};
