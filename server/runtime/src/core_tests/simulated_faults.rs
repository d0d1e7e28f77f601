//! Simulated faults: they reach the robot and all clients, and never the stack.

use super::*;

#[test]
fn a_simulated_fault_reaches_the_robot_and_all_clients_and_never_the_stack() {
    let (fault_sender, faults) = crossbeam_channel::unbounded();
    let bench = bench_of(usize::MAX, Some(fault_sender), None);
    bench.clock(0);
    let mut gateway = bench.gateway();
    let hour = Span::from_millis(3_600_000);
    gateway.command(1, api::Command::InjectFault(SimulatedFault::CoverLidar(hour)));
    let (id, fault) = faults.recv_timeout(PATIENCE).expect("the robot is asked");
    assert_eq!(fault, SimulatedFault::CoverLidar(Span::from_millis(600_000)));
    bench.event(10, RobotEvent::FaultAnswered { id, refused: None });
    let (mut answered, mut notice) = (None, None);
    while answered.is_none() || notice.is_none() {
        gateway.event(|_, event| {
            match event {
                Event::CommandDone { outcome, .. } => answered = Some(outcome.clone()),
                Event::Notice(published) if published.text.starts_with("Simulated") => {
                    notice = Some(published.text.clone());
                }
                _ => {}
            }
            Some(())
        });
    }
    assert_eq!(answered, Some(CommandOutcome::Accepted));
    assert_eq!(notice.as_deref(), Some("Simulated: the LiDAR is covered for 600 s."));

    // The robot refuses the second fault, and is disconnected before it answers the third one.
    let mut outcome_after = |number: u128, event: &dyn Fn(CommandId) -> RobotEvent| {
        gateway.command(number, api::Command::InjectFault(SimulatedFault::CarryAway));
        let (id, _) = faults.recv_timeout(PATIENCE).expect("the robot is asked");
        bench.event(10, event(id));
        gateway.event(|_, event| match event {
            Event::CommandDone { id: done, outcome } if *done == id => Some(outcome.clone()),
            _ => None,
        })
    };
    let refused = "No place is free.".to_owned();
    let outcome = outcome_after(2, &|id| RobotEvent::FaultAnswered { id, refused: Some(refused.clone()) });
    assert_eq!(outcome, CommandOutcome::Refused(refused.clone()));
    let outcome = outcome_after(3, &|_| RobotEvent::Disconnected("The robot is away.".to_owned()));
    assert!(matches!(outcome, CommandOutcome::Refused(_)), "{outcome:?}");
    bench.clock(1_000);
    loop {
        let (millis, input) = bench.written();
        assert!(!matches!(input, Input::Command(_)), "{input:?}");
        if millis >= 1_000 {
            break;
        }
    }
}

#[test]
fn a_real_robot_refuses_simulated_faults() {
    let bench = bench(usize::MAX);
    bench.clock(0);
    let mut gateway = bench.gateway();
    gateway.command(1, api::Command::InjectFault(SimulatedFault::CarryAway));
    let outcome = gateway.event(|_, event| match event {
        Event::CommandDone { outcome, .. } => Some(outcome.clone()),
        _ => None,
    });
    assert!(matches!(outcome, CommandOutcome::Refused(_)), "{outcome:?}");
}
