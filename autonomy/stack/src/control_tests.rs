//! The lease, its refusals, and answers to repeated commands.

use super::*;
use messages::Principal;
use uuid::Uuid;

fn command(id: u128, client: u128, role: Role, kind: CommandKind) -> Command {
    let by = Principal { role, ..Principal::operator(ClientId(Uuid::from_u128(client))) };
    Command { id: CommandId(Uuid::from_u128(id)), by, kind }
}

#[test]
fn the_lease_goes_to_the_first_client_and_the_others_may_only_stop() {
    let mut control = ControlArbiter::default();
    let first = command(1, 1, Role::Operator, CommandKind::AllowMotion);
    assert!(matches!(control.admit(&first), Admission::Granted { changed: true }));
    let second = command(2, 2, Role::Operator, CommandKind::AllowMotion);
    let Admission::Refused(reason) = control.admit(&second) else { panic!("the lease is held") };
    assert_eq!(reason, texts::control_held_by(texts::UNNAMED_OPERATOR));
    let stop = command(3, 2, Role::Operator, CommandKind::StopMotion);
    assert!(matches!(control.admit(&stop), Admission::Granted { changed: false }));
    let take = command(4, 2, Role::Operator, CommandKind::TakeControl { name: "Ada".to_owned() });
    assert!(matches!(control.admit(&take), Admission::Granted { changed: true }));
    assert_eq!(control.state().owner, Some(ClientId(Uuid::from_u128(2))));
}

#[test]
fn a_viewer_may_only_stop_motion() {
    let mut control = ControlArbiter::default();
    let take = command(1, 1, Role::Viewer, CommandKind::TakeControl { name: "Ada".to_owned() });
    assert!(matches!(control.admit(&take), Admission::Refused(_)));
    assert_eq!(control.state().owner, None);
    let stop = command(2, 1, Role::Viewer, CommandKind::StopMotion);
    assert!(matches!(control.admit(&stop), Admission::Granted { changed: false }));
}

#[test]
fn a_command_that_is_sent_again_is_answered_as_before() {
    let mut control = ControlArbiter::default();
    let once = command(1, 1, Role::Operator, CommandKind::AllowMotion);
    assert!(matches!(control.admit(&once), Admission::Granted { .. }));
    control.keep_answer(once.id, Some("no".to_owned()));
    assert!(matches!(control.admit(&once), Admission::Repeated(Some(answer)) if answer == "no"));
}

#[test]
fn only_the_newest_answers_are_kept() {
    let mut control = ControlArbiter {
        config: ControlConfig { max_answers: 2, ..ControlConfig::default() },
        ..ControlArbiter::default()
    };
    let commands = [1, 2, 3].map(|id| command(id, 1, Role::Operator, CommandKind::AllowMotion));
    for command in &commands {
        assert!(matches!(control.admit(command), Admission::Granted { .. }));
        control.keep_answer(command.id, None);
    }
    assert!(matches!(control.admit(&commands[0]), Admission::Granted { .. }), "its answer is forgotten");
    assert!(matches!(control.admit(&commands[1]), Admission::Repeated(None)));
}

#[test]
fn only_the_holder_gives_the_lease_back_and_names_are_cut() {
    let mut control = ControlArbiter::default();
    let take = command(1, 1, Role::Operator, CommandKind::TakeControl { name: "n".repeat(200) });
    assert!(matches!(control.admit(&take), Admission::Granted { changed: true }));
    assert_eq!(control.state().name.len(), ControlConfig::default().max_name_chars);
    let by_other = command(2, 2, Role::Operator, CommandKind::ReleaseControl);
    assert!(matches!(control.admit(&by_other), Admission::Granted { changed: false }));
    assert!(control.state().owner.is_some());
    let by_holder = command(3, 1, Role::Operator, CommandKind::ReleaseControl);
    assert!(matches!(control.admit(&by_holder), Admission::Granted { changed: true }));
    assert_eq!(control.state(), &ControlState::default());
}
