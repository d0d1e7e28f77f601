//! Mapping sessions whose core was killed: nothing is lost, and a person decides.

use crate::core_process::{CoreProcess, finish, map_a_little, map_names};
use crate::fake_gateway::{FakeGateway, until};
use api::{Command, Event, InterruptedSession, Mapping};
use std::path::Path;
use uuid::Uuid;
use vocab::{MapId, SessionId};

fn map(number: u128) -> MapId {
    MapId(Uuid::from_u128(number))
}

fn session(number: u128) -> SessionId {
    SessionId(Uuid::from_u128(number))
}

/// The sessions that the core offers.
fn offered(gateway: &mut FakeGateway) -> Vec<InterruptedSession> {
    gateway.event(|event| match event {
        Event::InterruptedSessions(sessions) => Some(sessions.clone()),
        _ => None,
    })
}

/// A core that was killed after some keyframes of a session, and started again.
fn interrupted(data: &Path) -> (CoreProcess, FakeGateway) {
    let core = CoreProcess::start(data);
    let mut gateway = FakeGateway::connect(&core.socket);
    map_a_little(&mut gateway, 1);
    core.kill();
    let core = CoreProcess::start(data);
    let mut gateway = FakeGateway::connect(&core.socket);
    let sessions = offered(&mut gateway);
    assert_eq!(sessions.len(), 1);
    // Three keyframes were published before the core was killed. The cloud of the last one may not have been on the disk.
    assert!(sessions[0].session == session(1) && sessions[0].keyframes >= 2, "{sessions:?}");
    (core, gateway)
}

#[test]
fn a_killed_session_is_offered_until_it_is_saved() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let (core, _) = interrupted(dir.path());
    // Nothing is deleted until a person decides.
    core.kill();
    let core = CoreProcess::start(dir.path());
    let mut gateway = FakeGateway::connect(&core.socket);
    let sessions = offered(&mut gateway);
    let name = "Hall".to_owned();
    gateway.command(Command::SaveInterruptedSession {
        session: session(1),
        map: map(9),
        name,
        resume_as: None,
    });
    core.kill();
    let core = CoreProcess::start(dir.path());
    let mut gateway = FakeGateway::connect(&core.socket);
    let mut maps = None;
    let left = loop {
        let both = gateway.event(|event| match event {
            Event::Maps(listed) => {
                maps = Some(listed.clone());
                None
            }
            Event::InterruptedSessions(sessions) => Some(sessions.clone()),
            _ => None,
        });
        if maps.is_some() {
            break both;
        }
    };
    let maps = maps.expect("listed");
    assert_eq!((maps.len(), maps[0].id, maps[0].keyframes), (1, map(9), sessions[0].keyframes));
    assert!(maps[0].points > 1_000 && left.is_empty());
}

#[test]
fn a_killed_session_goes_on_as_an_extension_of_its_map() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let (core, mut gateway) = interrupted(dir.path());
    let name = "Hall".to_owned();
    let resume_as = Some(session(2));
    gateway.command(Command::SaveInterruptedSession { session: session(1), map: map(9), name, resume_as });
    // The session may begin before the command is answered, so a new connection asks for the state.
    FakeGateway::connect(&core.socket).event(|event| match event {
        Event::Mapping(Mapping::Finding { session: found, map: base, .. })
        | Event::Mapping(Mapping::Running { session: found, extends: Some(base), .. })
            if (*found, *base) == (session(2), map(9)) =>
        {
            Some(())
        }
        _ => None,
    });
}

#[test]
fn a_session_whose_core_is_killed_while_it_is_saved_is_a_map_or_is_offered() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let core = CoreProcess::start(dir.path());
    let mut gateway = FakeGateway::connect(&core.socket);
    map_a_little(&mut gateway, 1);
    gateway.command(finish(7));
    let hidden = format!(".{}", map(7));
    until("saving begins", || {
        map_names(dir.path())
            .iter()
            .any(|name| name.trim_start_matches('.') == map(7).to_string())
            .then_some(())
    });
    core.kill();
    let core = CoreProcess::start(dir.path());
    let mut gateway = FakeGateway::connect(&core.socket);
    let is_saved = map_names(dir.path()).contains(&map(7).to_string());
    let sessions = offered(&mut gateway);
    assert!(!map_names(dir.path()).contains(&hidden));
    assert_eq!(sessions.len(), usize::from(!is_saved), "{sessions:?}");
    for session in sessions {
        assert!(session.keyframes >= 2);
        gateway.command(Command::DiscardInterruptedSession(session.session));
    }
    core.kill();
    let core = CoreProcess::start(dir.path());
    assert!(offered(&mut FakeGateway::connect(&core.socket)).is_empty());
}
