//! Maps are renamed, deleted and restored, by a core that is killed after each step.

use crate::core_process::CoreProcess;
use crate::fake_gateway::FakeGateway;
use crate::stored_data::{copy, data_of_november_2026};
use api::{Command, CommandOutcome, Event, MapSummary};
use std::fs;
use std::path::Path;

/// A core over this data that has sent its list of maps, with that list and the number of maps in the bin.
fn start(data: &Path) -> (CoreProcess, FakeGateway, Vec<MapSummary>, usize) {
    let core = CoreProcess::start(data);
    let mut gateway = FakeGateway::connect(&core.socket);
    let (mut maps, mut binned) = (None, None);
    while maps.is_none() || binned.is_none() {
        gateway.event(|event| {
            match event {
                Event::Maps(listed) => maps = Some(listed.clone()),
                Event::BinnedMaps(listed) => binned = Some(listed.len()),
                _ => return None,
            }
            Some(())
        });
    }
    (core, gateway, maps.unwrap_or_default(), binned.unwrap_or_default())
}

#[test]
fn what_is_renamed_deleted_and_restored_stays_so_when_the_core_is_killed() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let data = dir.path().join("data");
    copy(&data_of_november_2026(), &data);
    let (core, mut gateway, maps, _) = start(&data);
    let map = maps[0].id;
    // The robot is localised in this map since the last run.
    let CommandOutcome::Refused(sentence) = gateway.outcome(Command::DeleteMap(map)) else {
        panic!("a map in use was deleted")
    };
    assert!(sentence.contains("Leave the map"), "{sentence}");
    gateway.command(Command::RenameMap { map, name: "Cellar".to_owned() });
    core.kill();

    let (core, mut gateway, maps, _) = start(&data);
    assert_eq!(maps[0].name, "Cellar");
    gateway.command(Command::TakeControl { name: "Test".to_owned() });
    gateway.command(Command::LeaveMap);
    gateway.command(Command::DeleteMap(map));
    core.kill();

    let (core, mut gateway, maps, binned) = start(&data);
    assert_eq!((maps.len(), binned), (0, 1));
    gateway.command(Command::RestoreMap(map));
    core.kill();

    let (core, mut gateway, maps, binned) = start(&data);
    assert_eq!((maps[0].name.as_str(), binned), ("Cellar", 0));
    let docks = gateway.event(|event| match event {
        Event::Docks(docks) => Some(docks.clone()),
        _ => None,
    });
    assert_eq!((docks.len(), docks[0].map), (1, map), "its dock came back with it");
    gateway.command(Command::DeleteMap(map));
    gateway.command(Command::DeleteMapPermanently(map));
    core.kill();
    let (_core, _, maps, binned) = start(&data);
    assert_eq!((maps.len(), binned), (0, 0));
    assert_eq!(fs::read_dir(data.join("bin")).expect("readable").count(), 0);
    assert!(fs::read_dir(data.join("tiles")).expect("readable").count() > 0, "tiles have a day's grace");
}
