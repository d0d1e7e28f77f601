//! Floods of refusals and commands make few entries.

use super::*;
use api::Role;
use uuid::Uuid;
use vocab::MapId;

fn ada() -> Principal {
    let client = ClientId(Uuid::from_u128(1));
    Principal { client, account: Some("ada".to_owned()), role: Role::Operator }
}

/// The entries that are ready, with their count. The ledger's thread takes none.
fn ready(audit: &CommandAudit) -> Vec<AuditEntry> {
    std::mem::take(&mut lock(&audit.state).ready)
}

fn audit() -> CommandAudit {
    CommandAudit::new(|_| false)
}

#[test]
fn refusals_that_are_equal_are_one_entry_with_their_number() {
    let (audit, address) = (audit(), Some([192, 0, 2, 1].into()));
    for _ in 0..10_000 {
        audit.refuse(Some(ada()), address, "edit", "Too many.");
    }
    let first = ready(&audit);
    assert_eq!(first.len(), 1, "{first:?}");
    assert_eq!((first[0].by.clone(), first[0].address), (Some(ada()), address));
    assert_eq!(first[0].outcome, "refused: Too many.");
    audit.flush(Instant::now() + CONFIG.refusal_period);
    let rest = ready(&audit);
    assert_eq!(rest.len(), 1, "{rest:?}");
    assert_eq!(rest[0].outcome, "refused: Too many. (9999 times)");
}

#[test]
fn a_flood_of_different_refusals_is_bounded_and_hides_nobody_who_has_signed_in() {
    let audit = audit();
    for number in 0..10_000 {
        audit.refuse(None, None, &format!("request {number}"), "No.");
    }
    audit.refuse(Some(ada()), None, "edit", "No.");
    let entries = ready(&audit);
    assert_eq!(entries.len(), CONFIG.max_refusals + 2);
    assert!(entries.iter().any(|entry| entry.by == Some(ada())));
    assert!(entries.iter().any(|entry| entry.command == audit_texts::OTHER_REQUESTS));
}

#[test]
fn a_flood_of_commands_of_one_account_is_counted_and_another_account_keeps_its_entries() {
    let audit = audit();
    let give = |number: u128, by: &Principal| {
        let command = Command::DeleteMap(MapId(Uuid::from_u128(number)));
        let id = CommandId(Uuid::from_u128(number));
        audit.begin(id, by, &by.client.into(), &command);
        audit.finish(id, &CommandOutcome::Accepted);
    };
    (0..10_000).for_each(|number| give(number, &ada()));
    let bob = Principal { account: Some("bob".to_owned()), ..ada() };
    give(20_000, &bob);
    audit.flush(Instant::now() + CONFIG.refusal_period);
    let entries = ready(&audit);
    let of = |by: &Principal| entries.iter().filter(|entry| entry.by.as_ref() == Some(by)).count();
    assert!(of(&ada()) <= CONFIG.command_burst as usize + 10, "{}", of(&ada()));
    assert_eq!(of(&bob), 1);
    let mut further = entries.iter().filter(|entry| entry.command == audit_texts::FURTHER_COMMANDS);
    assert!(further.next_back().is_some_and(|entry| entry.outcome.contains("times")));
}

#[test]
fn while_the_disk_fails_what_waits_is_bounded() {
    let audit = audit();
    for _ in 0..2 * CONFIG.max_ready {
        audit.ended(&ada(), None, "import of Hall", "done");
    }
    assert_eq!(ready(&audit).len(), CONFIG.max_ready);
    audit.ended(&ada(), None, "import of Hall", "done");
    assert!(ready(&audit)[0].outcome.contains(&CONFIG.max_ready.to_string()));
}
