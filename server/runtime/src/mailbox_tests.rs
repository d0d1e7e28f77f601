//! Order, replacement, waiting, and the bound.

use super::*;
use crate::testing::{SESSION, keyframe};
use messages::{GraphDelta, MappingState, PoseGraph};
use std::sync::Arc;
use std::thread;
use std::time::Duration;
use vocab::Span;

fn notice(text: &str) -> Publication {
    Publication::Notice(Notice { at: Stamp::EPOCH, severity: Severity::Info, text: text.to_owned() })
}

fn estimate(nanos: i64) -> Publication {
    Publication::Estimate(Estimate { stamp: Stamp::EPOCH + Span::from_nanos(nanos), ..Estimate::default() })
}

#[test]
fn only_the_newest_estimate_and_scan_wait_and_everything_else_in_order() {
    let mailbox = Mailbox::default();
    for nanos in 1..=3 {
        mailbox.post(estimate(nanos));
        mailbox.post(notice(&nanos.to_string()));
        let stamp = Stamp::EPOCH + Span::from_nanos(nanos);
        mailbox.post(Publication::Scan(CorrectedScan { stamp, ..CorrectedScan::default() }));
    }
    let mail = mailbox.wait(Instant::now());
    assert_eq!(mail.ordered, ["1", "2", "3"].map(notice));
    assert_eq!(mail.estimate.map(|estimate| estimate.stamp.nanos()), Some(3));
    assert_eq!(mail.scan.map(|scan| scan.stamp.nanos()), Some(3));
    assert!(!mail.closed);
    assert!(mailbox.wait(Instant::now()).is_empty(), "everything was taken");
}

#[test]
fn a_waiting_publisher_is_woken_by_a_publication_and_by_the_end() {
    let mailbox = Arc::new(Mailbox::default());
    let never = Instant::now() + Duration::from_secs(3_600);
    let waiting = thread::spawn({
        let mailbox = Arc::clone(&mailbox);
        move || [mailbox.wait(never), mailbox.wait(never)]
    });
    mailbox.notice(Stamp::EPOCH, Severity::Info, "first".to_owned());
    // The first wait has returned once the publication is gone.
    while !mailbox.lock().ordered.is_empty() {
        thread::yield_now();
    }
    mailbox.close();
    let [first, second] = waiting.join().expect("no panic");
    assert_eq!(first.ordered, [notice("first")]);
    assert!(second.closed && second.is_empty());
}

/// A minute's worth of everything that a walk over new ground publishes.
fn walk(mailbox: &Mailbox, first: u32, count: u32) {
    for id in first..first + count {
        let revision = u64::from(id);
        let nodes = vec![GraphNode { id: KeyframeId(id), ..node() }; 50];
        let state = MappingState::Mapping {
            session: SESSION,
            extends: None,
            since: Stamp::EPOCH,
            distance_m: f64::from(id),
            keyframes: id + 1,
            on_known_ground: false,
        };
        let delta = GraphDelta {
            session: SESSION,
            base_revision: revision,
            revision: revision + 1,
            nodes,
            removed_loops: Vec::new(),
            edges: Vec::new(),
        };
        mailbox.post(Publication::Mapping(state));
        mailbox.post(Publication::Keyframe(keyframe(SESSION, id)));
        mailbox.post(Publication::GraphDelta(Arc::new(delta)));
        mailbox.post(notice(&id.to_string()));
        mailbox.post(estimate(i64::from(id)));
    }
}

fn node() -> GraphNode {
    GraphNode { id: KeyframeId(0), stamp: Stamp::EPOCH, map_from_keyframe: vocab::Pose::IDENTITY }
}

#[test]
fn a_publisher_that_stands_still_costs_no_more_than_the_bound() {
    let mailbox = Mailbox::default();
    let config = mailbox.config;
    let (mut most, mut total) = (0, 0);
    for first in (0..50_000).step_by(10) {
        walk(&mailbox, first, 10);
        let mail = mailbox.lock();
        let bytes: usize = mail.ordered.iter().map(bytes_of).sum();
        assert_eq!(bytes, mail.bytes);
        most = most.max(bytes);
        assert!(mail.ordered.len() <= config.max_publications);
        total += 10 * bytes_of(&Publication::Keyframe(keyframe(SESSION, 0)));
    }
    assert!(most <= config.max_bytes, "{most} bytes");
    assert!(total > 4 * config.max_bytes, "{total} bytes of clouds alone were posted");
    mailbox.post(Publication::Graph {
        session: SESSION,
        graph: Arc::new(PoseGraph { nodes: vec![node(); 1_000_000], ..PoseGraph::default() }),
    });
    let mail = mailbox.wait(Instant::now());
    assert!(mail.bytes <= config.max_bytes && mail.is_graph_dropped, "a graph longer than the bound");
    let dropped = mail.dropped_keyframes.expect("clouds were dropped");
    let waiting: Vec<u32> = mail
        .ordered
        .iter()
        .filter_map(|publication| match publication {
            Publication::Keyframe(keyframe) => Some(keyframe.id.0),
            _ => None,
        })
        .collect();
    assert_eq!((dropped.session, dropped.first.0), (SESSION, 0));
    let known: Vec<u32> = (0..=dropped.last.0).chain(waiting).collect();
    assert_eq!(known, (0..50_000).collect::<Vec<_>>(), "every keyframe waits or is named");
    let mut states = mail.ordered.iter().filter(|publication| matches!(publication, Publication::Mapping(_)));
    assert!(states.next_back().is_some_and(|state| matches!(
        state,
        Publication::Mapping(MappingState::Mapping { keyframes: 50_000, .. })
    )));
    assert!(mail.ordered.contains(&notice("49999")));
    assert!(mailbox.wait(Instant::now()).is_empty(), "everything was taken");
}

#[test]
fn a_compacted_mailbox_keeps_the_newest_of_each_kind_and_the_sessions_in_order() {
    let config = MailboxConfig { max_publications: 3, ..MailboxConfig::default() };
    let mailbox = Mailbox { config, ..Mailbox::default() };
    let other = SessionId(uuid::Uuid::from_u128(8));
    let starting = |session| Publication::Mapping(MappingState::Starting { session });
    mailbox.post(starting(SESSION));
    mailbox.post(Publication::Keyframe(keyframe(SESSION, 4)));
    mailbox.post(Publication::Motion(MotionState::Idle));
    mailbox.post(Publication::Motion(MotionState::Teleoperated));
    mailbox.post(starting(other));
    mailbox.post(Publication::Keyframe(keyframe(other, 0)));
    mailbox.post(Publication::Keyframe(keyframe(other, 1)));
    let mail = mailbox.wait(Instant::now());
    let expected = [starting(SESSION), starting(other), Publication::Motion(MotionState::Teleoperated)];
    assert_eq!(mail.ordered, expected);
    let range = (KeyframeId(0), KeyframeId(1));
    let dropped = mail.dropped_keyframes.expect("of the session that is shown");
    assert_eq!((dropped.session, (dropped.first, dropped.last)), (other, range));
}
