//! What people decide about mapping sessions that were interrupted: save, save and go on, or discard. It is done by the disk lane.

use crate::clock::{CalendarTime, RobotClock};
use crate::mailbox::Mailbox;
use crate::map_list::publish_map_list;
use crate::state_publisher::StatePublisher;
use crate::texts;
use api::{Event, InterruptedSession};
use messages::{Command, CommandKind, Principal, Severity};
use ports::error_with_causes;
use std::sync::Arc;
use store::Store;
use vocab::{CommandId, MapId, SessionId};

/// A decision of a person.
pub struct SessionRequest {
    /// Made by the client.
    pub id: CommandId,
    /// Who asks.
    pub by: Principal,
    /// What is to be done.
    pub decision: SessionDecision,
}

/// What is to be done with an interrupted session.
pub enum SessionDecision {
    /// Save it as a map.
    Save {
        session: SessionId,
        map: MapId,
        name: String,
        /// Id of a session that then extends the map, if one is wanted.
        resume_as: Option<SessionId>,
    },
    /// Delete it.
    Discard(SessionId),
}

/// Carries decisions out. Only sessions that the start of the program found can be decided on, so that the running one is safe.
pub struct InterruptedSessionWorker {
    pub store: Arc<Store>,
    pub state_publisher: Arc<StatePublisher>,
    pub mailbox: Arc<Mailbox>,
    pub clock: Arc<RobotClock>,
    /// Hands a command to the stack, which answers it.
    pub command: Box<dyn Fn(Command) + Send>,
    /// The sessions that wait for a decision.
    pub sessions: Vec<InterruptedSession>,
}

impl InterruptedSessionWorker {
    /// Carries out a decision and answers it.
    pub fn handle(&mut self, request: SessionRequest) {
        let SessionRequest { id, by, decision } = request;
        let (done, next) = match decision {
            SessionDecision::Save { session, map, name, resume_as } => {
                let extend = |session| CommandKind::ExtendMap { session, map };
                (self.save(session, map, &name), resume_as.map(extend))
            }
            SessionDecision::Discard(session) => (self.discard(session), None),
        };
        match (done, next) {
            (Ok(()), Some(kind)) => (self.command)(Command { id, by, kind }),
            (done, _) => self.state_publisher.answer(id, by.client, done.err()),
        }
    }

    fn save(&mut self, session: SessionId, map: MapId, name: &str) -> Result<(), String> {
        self.check_is_interrupted(session)?;
        let name = stack::map_name(name).ok_or_else(|| texts::MAP_NEEDS_NAME.to_owned())?;
        let saved = self.store.save_interrupted_session(session, map, &name);
        let (_, problems) = saved.map_err(|error| texts::session_not_saved(&error_with_causes(&error)))?;
        for problem in problems {
            self.mailbox.notice(self.clock.now(), Severity::Warning, problem);
        }
        if let Err(error) = publish_map_list(&self.store, &self.state_publisher, CalendarTime::read()) {
            tracing::error!("{}", error_with_causes(&error));
        }
        // The session's map is on the disk, so a session that cannot be removed now is removed at the next start.
        if let Err(error) = self.store.discard_session(session) {
            tracing::warn!("files of session {session} are left over: {}", error_with_causes(&error));
        }
        self.forget(session);
        self.mailbox.notice(self.clock.now(), Severity::Info, texts::session_saved(&name));
        Ok(())
    }

    fn discard(&mut self, session: SessionId) -> Result<(), String> {
        self.check_is_interrupted(session)?;
        self.store
            .discard_session(session)
            .map_err(|error| texts::session_not_discarded(&error_with_causes(&error)))?;
        self.forget(session);
        Ok(())
    }

    fn check_is_interrupted(&self, session: SessionId) -> Result<(), String> {
        let is_listed = self.sessions.iter().any(|listed| listed.session == session);
        if is_listed { Ok(()) } else { Err(texts::SESSION_NOT_INTERRUPTED.to_owned()) }
    }

    fn forget(&mut self, session: SessionId) {
        self.sessions.retain(|listed| listed.session != session);
        self.state_publisher.publish(Event::InterruptedSessions(self.sessions.clone()));
    }
}
