//! Take-overs that are granted, refused and not asked for, and leases of clients that have gone.

use super::*;

const HOLDER: ClientId = ClientId(Uuid::from_u128(1));
const OTHER: ClientId = ClientId(Uuid::from_u128(2));
const THIRD: ClientId = ClientId(Uuid::from_u128(3));
const AT: Stamp = Stamp::EPOCH;

/// An arbiter of a lease that `HOLDER` has, while the first three are connected.
fn held(now: Instant) -> LeaseArbiter {
    let arbiter = LeaseArbiter::new(LeaseConfig::default(), Arc::default());
    arbiter.set_clients([HOLDER, OTHER, THIRD], now);
    arbiter.set_lease(ControlState { owner: Some(HOLDER), name: "ada".into() }, now);
    arbiter
}

fn request(arbiter: &LeaseArbiter, client: ClientId, role: Role, now: Instant) -> LeaseDecision {
    let by = Principal { role, ..Principal::operator(client) };
    let kind = CommandKind::TakeControl { name: "bob".into() };
    arbiter.request(Command { id: new_id(), by, kind }, "bob".into(), client.into(), now)
}

fn after(now: Instant, seconds: f64) -> Instant {
    now + Duration::from_secs_f64(seconds)
}

/// Whom the stack is told to give the lease to, if anybody; `None` in place of a client: it is given back.
fn due(arbiter: &LeaseArbiter, now: Instant) -> Option<Option<ClientId>> {
    let due = arbiter.due(AT, now)?;
    Some(matches!(due.command.kind, CommandKind::TakeControl { .. }).then_some(due.command.by.client))
}

#[test]
fn a_take_over_that_is_not_refused_is_granted_after_five_seconds() {
    let now = Instant::now();
    let arbiter = held(now);
    assert_eq!(request(&arbiter, OTHER, Role::Operator, now), LeaseDecision::Asked);
    assert_eq!(request(&arbiter, OTHER, Role::Operator, after(now, 1.0)), LeaseDecision::Asked, "as before");
    assert!(
        matches!(request(&arbiter, THIRD, Role::Operator, now), LeaseDecision::Refused(_)),
        "one at a time"
    );
    assert_eq!(due(&arbiter, after(now, 4.9)), None);
    assert_eq!(due(&arbiter, after(now, 5.0)), Some(Some(OTHER)));
    assert_eq!(due(&arbiter, after(now, 5.1)), None, "once");
}

#[test]
fn the_holder_refuses_and_the_same_client_waits_before_it_asks_again() {
    let now = Instant::now();
    let arbiter = held(now);
    assert!(arbiter.refuse(&Principal::operator(HOLDER), AT, now).is_err(), "nobody asks");
    request(&arbiter, OTHER, Role::Operator, now);
    assert!(arbiter.refuse(&Principal::operator(THIRD), AT, now).is_err(), "not the holder");
    assert_eq!(arbiter.refuse(&Principal::operator(HOLDER), AT, after(now, 4.0)), Ok(()));
    assert_eq!(due(&arbiter, after(now, 6.0)), None);
    assert!(matches!(request(&arbiter, OTHER, Role::Operator, after(now, 6.0)), LeaseDecision::Refused(_)));
    assert_eq!(request(&arbiter, THIRD, Role::Operator, after(now, 6.0)), LeaseDecision::Asked);
    let now = after(now, 20.0);
    assert_eq!(due(&arbiter, now), Some(Some(THIRD)));
}

#[test]
fn an_admin_and_whoever_has_the_lease_are_not_refused() {
    let now = Instant::now();
    let arbiter = held(now);
    assert!(matches!(request(&arbiter, OTHER, Role::Admin, now), LeaseDecision::Grant(_)));
    assert!(matches!(request(&arbiter, HOLDER, Role::Operator, now), LeaseDecision::Grant(_)));
    arbiter.set_lease(ControlState::default(), now);
    assert!(matches!(request(&arbiter, OTHER, Role::Operator, now), LeaseDecision::Grant(_)), "it is free");
}

#[test]
fn a_holder_without_a_connection_is_not_asked_and_loses_the_lease() {
    let now = Instant::now();
    let arbiter = held(now);
    arbiter.set_clients([OTHER], now);
    assert!(matches!(request(&arbiter, OTHER, Role::Operator, now), LeaseDecision::Grant(_)));
    assert_eq!(due(&arbiter, after(now, 14.9)), None);
    assert_eq!(due(&arbiter, after(now, 15.0)), Some(None));
    // A holder who is back in time keeps it.
    let arbiter = held(now);
    arbiter.set_clients([OTHER], now);
    arbiter.set_clients([HOLDER, OTHER], after(now, 10.0));
    assert_eq!(due(&arbiter, after(now, 30.0)), None);
}

#[test]
fn whoever_asks_gets_the_lease_when_its_holder_goes_or_gives_it_back() {
    let now = Instant::now();
    for is_gone in [true, false] {
        let arbiter = held(now);
        request(&arbiter, OTHER, Role::Operator, now);
        if is_gone {
            arbiter.set_clients([OTHER], now);
        } else {
            arbiter.set_lease(ControlState::default(), now);
        }
        assert_eq!(due(&arbiter, after(now, 1.0)), Some(Some(OTHER)));
    }
}
