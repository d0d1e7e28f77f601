//! Saving, resuming and discarding an interrupted session.

use crate::testing::*;
use crate::*;
use api::{Command, Event, InterruptedSession};
use uuid::Uuid;
use vocab::{SessionId, Stamp};

#[test]
fn an_interrupted_session_is_saved_resumed_or_discarded() {
    let mut client = TestClient::connected();
    let session = SessionId(Uuid::from_u128(4));
    let listed =
        InterruptedSession { session, at: Stamp::EPOCH, keyframes: 37, distance_m: 40.0, extends: None };
    client.event(Event::InterruptedSessions(vec![listed.clone()]));
    assert_eq!(client.model.interrupted_sessions.list(), [listed]);
    for wanted in [false, true] {
        let name = "Hall".to_owned();
        client.command(ClientCommand::SaveInterruptedSession { session, name, resume: wanted });
        let sent = client.take_commands();
        assert!(
            sent.iter().any(|command| matches!(
                command,
                Command::SaveInterruptedSession { session: saved, name, resume_as, .. }
                    if *saved == session && name == "Hall" && resume_as.is_some() == wanted
            )),
            "{sent:?}"
        );
    }
    client.command(ClientCommand::DiscardInterruptedSession(session));
    assert_eq!(client.take_commands(), [Command::DiscardInterruptedSession(session)]);
    client.event(Event::InterruptedSessions(Vec::new()));
    assert!(client.model.interrupted_sessions.list().is_empty());
}
