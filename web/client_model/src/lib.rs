//! State of the operator's client as a reducer: events and commands in, effects out. No egui, no sockets, no clock.
//!
//! [`Model::apply`] is the only way in. Views read the model and emit [`Command`]s; the shell turns sockets, timers and
//! finished downloads into [`Event`]s and carries out the [`Effect`]s. Time comes in as [`ClientTime`], randomness as
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
mod tiles;
mod time;
mod track;
mod undo;
mod upload;
mod view;

#[cfg(test)]
mod tests;

pub use align::Align;
pub use command::Command;
pub use compare::{CloudState, Comparison, Overlay, fitted, shift};
pub use drive::{Drive, SPEED_MPS_MAX, TELEOPERATION_PERIOD_S, TURN_RADPS_MAX};
pub use event::{CameraMove, Effect, Event, Socket};
pub use history::LoopStep;
pub use ids::Ids;
pub use link::{Link, LinkState, Throughput};
pub use loops::{LoopCounts, LoopGuess, LoopPair, LoopPick, Loops, Proposed};
pub use map_view::{Loading, MapView};
pub use model::{Model, Robot, Selection};
pub use notices::{Note, NoteId, Notes};
pub use pending::Pending;
pub use tiles::{Eye, TILE_POINTS_MAX, TILE_REQUESTS_MAX, TileSet, TileState};
pub use time::{Aged, ClientTime, ServerClock};
pub use track::Track;
pub use undo::{Changed, Undo};
pub use upload::Upload;
pub use view::{Bookmark, CameraPose, ColourBy, Screen, Theme, ViewSettings};
