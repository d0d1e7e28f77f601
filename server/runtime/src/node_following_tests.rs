//! The robot uses another version of the site's map.

use super::*;
use crate::ledger::{LedgerConfig, LedgerQueue, LedgerWorker, SiteKeeper};
use crate::state_publisher::StatePublisher;
use crate::testing::save_corridor;
use messages::Input;
use site_model::{Anchor, Node, NodeId, NodeKind, Object, PoseTolerance, SiteSettings};
use std::time::{Duration, Instant};
use vocab::{KeyframeId, Pose, Vec3};
use watchdog::Heartbeat;

const MAP: MapId = MapId(Uuid::from_u128(1));
const NEXT: MapId = MapId(Uuid::from_u128(2));

/// A node 1 m before a keyframe.
fn node(keyframe: u32) -> Node {
    let ahead = Pose { position: Vec3::new(1.0, 0.0, 0.0), ..Pose::IDENTITY };
    let position = Vec3::new(f64::from(keyframe) + 1.0, 0.0, 0.55);
    Node {
        id: NodeId(Uuid::from_u128(u128::from(keyframe))),
        name: format!("N{keyframe}"),
        kind: NodeKind::Waypoint,
        map_from_node: Pose { position, ..Pose::IDENTITY },
        anchor: Some(Anchor { keyframe: KeyframeId(keyframe), keyframe_from_node: ahead }),
        tolerance: PoseTolerance::default(),
        influence_area_m: Vec::new(),
        floor: 0,
        tags: Default::default(),
        properties: Default::default(),
    }
}

/// A site with a map and two nodes.
fn first_edit(site: &Site) -> Edit {
    let objects =
        [Object::Settings(SiteSettings::of_unnamed(MAP)), Object::Node(node(3)), Object::Node(node(15))];
    let id = EditId(Uuid::from_u128(50));
    let changes = objects.into_iter().flat_map(|object| site.put(id, object).changes);
    Edit { id, changes: changes.collect() }
}

/// The edits that follow when the robot is localised in these maps one after the other, and what people are told.
fn edits(maps: &[MapId]) -> (Vec<Edit>, Vec<String>) {
    let dir = tempfile::tempdir().expect("temporary directory");
    let store = Arc::new(Store::open(dir.path()).expect("opens"));
    save_corridor(&store, MAP, 0.0);
    save_corridor(&store, NEXT, 0.25);
    let (mailbox, clock) = (Arc::<Mailbox>::default(), Arc::<RobotClock>::default());
    let (queue, inbox) = LedgerQueue::new(LedgerConfig::default());
    let (inputs, stack) = crossbeam_channel::bounded(16);
    let site = SiteKeeper::open(
        Arc::clone(&store),
        Arc::<StatePublisher>::default(),
        inputs.clone(),
        Arc::clone(&mailbox),
        Arc::clone(&clock),
        LedgerConfig { retry_period: Duration::from_millis(1), ..LedgerConfig::default() },
    );
    inbox
        .change_site(SiteWork {
            by: Principal::operator(ClientId(Uuid::from_u128(5))),
            make: Box::new(first_edit),
            done: Box::new(|_| {}),
        })
        .expect("handed in");
    let mut follower =
        NodeFollower::new(Arc::clone(&store), Arc::clone(&inbox), Arc::clone(&mailbox), Arc::clone(&clock));
    for map in maps {
        let state = LocalisationState::Localised { map: *map, degradation: None };
        follower.watch(&Publication::Localisation(state));
        follower.watch(&Publication::Localisation(state));
    }
    drop(queue);
    let worker = LedgerWorker { store, inbox, site, inputs, mailbox: Arc::clone(&mailbox), clock };
    worker.run(&Heartbeat::unwatched());
    let edits = stack.try_iter().filter_map(|input| match input {
        Input::SiteEdited(edit) => Some(*edit),
        _ => None,
    });
    let mail = mailbox.wait(Instant::now());
    let notices = mail.ordered.into_iter().filter_map(|publication| match publication {
        Publication::Notice(notice) => Some(notice.text),
        _ => None,
    });
    (edits.skip(1).collect(), notices.collect())
}

#[test]
fn the_site_follows_its_map_in_one_edit_that_people_are_told_of() {
    let (edits, notices) = edits(&[MAP, NEXT]);
    let [edit] = &edits[..] else { panic!("{edits:?}") };
    let mut site = Site::default();
    let first = first_edit(&site);
    site.apply(&first, first.id).expect("of this state");
    site.apply(edit, edit.id).expect("of this state");
    assert_eq!(site.settings().and_then(|settings| settings.map), Some(NEXT));
    let [before_y, after_y] =
        [3, 15].map(|number| site.node(node(number).id).expect("a node").map_from_node.position.y);
    assert!(before_y == 0.0 && (after_y - 0.25).abs() < 1e-6, "{before_y} {after_y}");
    assert!(notices[0].contains("1 node has moved") && notices[0].contains("0.25 m"), "{notices:?}");
}

#[test]
fn a_site_stays_where_its_map_is_used_or_another_place_is() {
    assert_eq!(edits(&[MAP]), (Vec::new(), Vec::new()));
    // There is no such map.
    assert_eq!(edits(&[MapId(Uuid::from_u128(77))]), (Vec::new(), Vec::new()));
}
