//! When the robot is localised in another version of the site's map, the site follows: nodes, targets and zones move with the keyframes of the map, and that version
//! becomes the map of the site. It is one edit in the platform's name, which people are told of and can undo.

use crate::clock::{CalendarTime, RobotClock};
use crate::ledger::{LedgerInbox, SiteWork, refusal_reason};
use crate::mailbox::Mailbox;
use crate::texts;
use api::EditOutcome;
use messages::{LocalisationState, Principal, Publication, Severity};
use ports::error_with_causes;
use site_model::{Edit, EditId, Site};
use std::sync::{Arc, Mutex, PoisonError};
use store::Store;
use topomap::{FollowConfig, Following, MapMotion};
use uuid::Uuid;
use vocab::{ClientId, MapId};

/// Lets the site follow its map. Belongs to the control loop, and never blocks it: the ledger's thread reads the poses of both versions.
pub struct NodeFollower {
    store: Arc<Store>,
    ledger: Arc<LedgerInbox>,
    mailbox: Arc<Mailbox>,
    clock: Arc<RobotClock>,
    /// The map in which the robot was localised last.
    map: Option<MapId>,
}

impl NodeFollower {
    /// For this site.
    pub fn new(
        store: Arc<Store>,
        ledger: Arc<LedgerInbox>,
        mailbox: Arc<Mailbox>,
        clock: Arc<RobotClock>,
    ) -> Self {
        Self { store, ledger, mailbox, clock, map: None }
    }

    /// Follows what the stack publishes of the robot's place.
    pub fn watch(&mut self, publication: &Publication) {
        let Publication::Localisation(LocalisationState::Localised { map, .. }) = publication else { return };
        if self.map.replace(*map) != Some(*map) {
            self.follow(*map);
        }
    }

    fn follow(&self, map: MapId) {
        let id = EditId(Uuid::from_u64_pair(
            CalendarTime::read().utc.nanos().unsigned_abs(),
            map.0.as_u64_pair().1,
        ));
        let store = Arc::clone(&self.store);
        let moved = Arc::new(Mutex::new(None));
        let (of_edit, mailbox, clock) =
            (Arc::clone(&moved), Arc::clone(&self.mailbox), Arc::clone(&self.clock));
        let handed_in = self.ledger.change_site(SiteWork {
            by: Principal::operator(ClientId(Uuid::nil())),
            make: Box::new(move |site| {
                let Some(Following { edit, moved_nodes, max_distance_m }) = following(&store, site, map, id)
                else {
                    return Edit { id, changes: Vec::new() };
                };
                *moved.lock().unwrap_or_else(PoisonError::into_inner) = Some((moved_nodes, max_distance_m));
                edit
            }),
            done: Box::new(move |outcome| {
                let moved = of_edit.lock().unwrap_or_else(PoisonError::into_inner).take();
                let (severity, text) = match (outcome, moved) {
                    (_, None) => return,
                    (EditOutcome::Applied { .. }, Some((nodes, distance_m))) => {
                        (Severity::Info, texts::site_follows_map(nodes, distance_m))
                    }
                    (EditOutcome::Refused(refusal), Some(_)) => {
                        (Severity::Warning, texts::site_does_not_follow(&refusal_reason(refusal)))
                    }
                };
                mailbox.notice(clock.now(), severity, text);
            }),
        });
        if let Err(reason) = handed_in {
            let text = texts::site_does_not_follow(reason);
            self.mailbox.notice(self.clock.now(), Severity::Warning, text);
        }
    }
}

/// The edit by which a site follows; none if it has no map, has this one, or one that is no version of it.
fn following(store: &Store, site: &Site, map: MapId, id: EditId) -> Option<Following> {
    let known = site.settings()?.map.filter(|known| *known != map)?;
    let read = |map| {
        store.keyframe_poses(map).inspect_err(|error| {
            tracing::warn!("the site cannot follow its map: {}", error_with_causes(error));
        })
    };
    let (before, after) = (read(known).ok()?, read(map).ok()?);
    Some(MapMotion::between(&before, &after, FollowConfig::default())?.edit(site, map, id))
}

#[cfg(test)]
#[path = "node_following_tests.rs"]
mod tests;
