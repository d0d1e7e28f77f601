//! Ids that the client makes.

use site_model::{EditId, RunId};
use uuid::Uuid;
use vocab::{CommandId, GoalId, MapId, SessionId};

/// A source of ids that differ from all others in the world, if its seed does.
#[derive(Clone, Debug)]
pub struct Ids {
    next: u128,
}

impl Ids {
    /// `seed` is 128 random bits, drawn once when the page opens.
    pub fn new(seed: u128) -> Self {
        Self { next: seed }
    }

    fn draw(&mut self) -> Uuid {
        self.next = self.next.wrapping_add(1);
        uuid::Builder::from_random_bytes(self.next.to_be_bytes()).into_uuid()
    }

    /// For a command.
    pub fn command(&mut self) -> CommandId {
        CommandId(self.draw())
    }

    /// For a goal.
    pub fn goal(&mut self) -> GoalId {
        GoalId(self.draw())
    }

    /// For a mapping session.
    pub fn session(&mut self) -> SessionId {
        SessionId(self.draw())
    }

    /// For an edit of the site.
    pub fn edit(&mut self) -> EditId {
        EditId(self.draw())
    }

    /// For a run of a mission.
    pub fn run(&mut self) -> RunId {
        RunId(self.draw())
    }

    /// For a map version.
    pub fn map(&mut self) -> MapId {
        MapId(self.draw())
    }
}
