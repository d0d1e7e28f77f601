//! The example: the core makes it on request, puts it into the empty site, and the simulated robot finds its place in it.

use crate::core_process::CoreProcess;
use crate::fake_gateway::FakeGateway;
use api::{Command, CommandOutcome, CoreMessage, Event, Import, ImportStage, Localisation, SiteAssembly};
use site_model::{Object, Site, ValidationConfig};
use uuid::Uuid;
use vocab::UploadId;

/// A walk of a part of the hall, in which the robot comes past a plate.
const SHORT: [&str; 1] = ["--example-minutes=1.2"];

fn make(number: u128) -> (UploadId, Command) {
    let upload = UploadId(Uuid::from_u128(number));
    (upload, Command::MakeExample { upload, time_zone: "Europe/London".to_owned() })
}

/// The site, as a gateway gets it that connects now.
fn site_of(core: &CoreProcess) -> Site {
    let (mut gateway, mut assembly) = (FakeGateway::connect(&core.socket), SiteAssembly::default());
    loop {
        if let CoreMessage::Event { event: Event::SitePart(part), .. } = gateway.message()
            && let Some(state) = assembly.add(&part)
        {
            return state.site;
        }
    }
}

#[test]
fn it_is_made_put_into_the_site_and_the_robot_finds_its_place_in_it() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let core = CoreProcess::start_with_arguments(dir.path(), &SHORT);
    let mut gateway = FakeGateway::connect(&core.socket);
    let (upload, command) = make(1);
    gateway.command(command);
    let mut stages = Vec::new();
    // The work has low priority, so only each step of its progress has a limit of time.
    let (of, map) = loop {
        let import = gateway.event(|event| match event {
            Event::Import(import) => Some(import.clone()),
            _ => None,
        });
        match import {
            Import::Running { stage, share, .. } => {
                assert!((0.0..=1.0).contains(&share));
                if stages.last() != Some(&stage) {
                    stages.push(stage);
                }
            }
            Import::Done { upload, map } => break (upload, map),
            Import::Failed { reason, .. } => panic!("{reason}"),
            Import::None => {}
        }
    };
    assert_eq!(of, upload);
    assert_eq!(stages, [ImportStage::Walking, ImportStage::Writing, ImportStage::MakingTopomap]);
    drop(gateway);
    // The core has let the robot find its place, and nobody has control afterwards.
    let mut gateway = FakeGateway::connect(&core.socket);
    let localised = gateway.event(|event| match event {
        Event::Localisation(Localisation::Localised { map, .. }) => Some(*map),
        _ => None,
    });
    assert_eq!(localised, map);
    drop(gateway);
    let site = site_of(&core);
    let settings = site.settings().expect("the site has settings");
    assert_eq!((settings.map, settings.time_zone.as_str()), (Some(map), "Europe/London"));
    let mission = site.missions().next().expect("a mission");
    let points = site.objects().filter(|it| matches!(it.object, Object::InspectionPoint(_))).count();
    assert!(points > 0 && mission.tasks.len() == points, "{points} points, {mission:?}");
    let schedule = site.schedules().next().expect("a schedule");
    assert!(schedule.mission == mission.id && !schedule.is_paused, "{schedule:?}");
    assert!(site.docks().next().is_some(), "the walk begins on a dock");
    let problems = site.problems(&ValidationConfig::default());
    assert!(problems.is_empty(), "{problems:?}");
    assert!(!dir.path().join("maps").join(map.to_string()).join("example.json").exists());

    // A second one would be of a site in use.
    let mut gateway = FakeGateway::connect(&core.socket);
    let (again, command) = make(2);
    // It may be refused before the command is answered, so the answer is not waited for.
    gateway.send_command(command);
    let reason = gateway.event(|event| match event {
        Event::Import(Import::Failed { upload, reason, .. }) if *upload == again => Some(reason.clone()),
        _ => None,
    });
    assert!(reason.contains("There is a map named Example hall already"), "{reason}");
}

#[test]
fn it_can_be_cancelled_and_then_leaves_nothing_behind() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let core = CoreProcess::start_with_arguments(dir.path(), &SHORT);
    let mut gateway = FakeGateway::connect(&core.socket);
    let (upload, command) = make(1);
    gateway.command(command);
    gateway.event(|event| match event {
        Event::Import(Import::Running { stage: ImportStage::Walking, share, .. }) => {
            (*share > 0.0).then_some(())
        }
        _ => None,
    });
    assert_eq!(gateway.outcome(Command::CancelImport(upload)), CommandOutcome::Accepted);
    let reason = gateway.event(|event| match event {
        Event::Import(Import::Failed { reason, .. }) => Some(reason.clone()),
        _ => None,
    });
    assert_eq!(reason, "It was cancelled.");
    drop(gateway);
    assert!(site_of(&core).objects().next().is_none());
    let left = |folder| std::fs::read_dir(dir.path().join(folder)).expect("readable").count();
    assert_eq!((left("maps"), left("uploads")), (0, 0));
}
