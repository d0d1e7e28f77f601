//! Orders: ids, repetition, answers, driving.

use super::*;

#[test]
fn an_unanswered_order_is_repeated_under_its_id_after_a_short_loss() {
    let mut bench = Bench::connected();
    bench.event(api::Event::Control(Control { owner: Some(ME), name: String::new() }));
    bench.command(ClientCommand::StartMapping);
    let first = bench.take();
    assert!(matches!(&first[..], [ClientEffect::Send(ClientMessage::Command { .. })]), "{first:?}");
    lose(&mut bench);
    bench.wait(1.0);
    bench.take();
    bench.connect();
    let again = bench.take();
    assert!(again.contains(&first[0]), "the same command under the same id");
    assert!(bench.model.is_pending(|order| matches!(order, Command::StartMapping(_))));
}

#[test]
fn an_old_order_is_not_repeated_but_told() {
    let mut bench = Bench::connected();
    bench.command(ClientCommand::WalkTo(Vec3::default()));
    lose(&mut bench);
    bench.wait(60.0);
    bench.take();
    bench.connect();
    assert_eq!(bench.orders(), []);
    let notes = bench.model.notices.visible();
    assert!(notes.iter().any(|note| note.text.contains("Walking there may not have reached")), "{notes:?}");
}

#[test]
fn a_stop_is_sent_even_an_hour_later_and_needs_no_control() {
    let mut bench = Bench::connected();
    bench.event(api::Event::Control(Control { owner: Some(OTHER), name: "other".into() }));
    bench.command(ClientCommand::StopMotion);
    assert_eq!(bench.orders(), [Command::StopMotion]);
    lose(&mut bench);
    bench.wait(3600.0);
    bench.connect();
    assert_eq!(bench.orders(), [Command::StopMotion]);
}

#[test]
fn a_stop_without_a_link_says_that_it_did_not_arrive() {
    let mut bench = Bench::new();
    bench.command(ClientCommand::StopMotion);
    assert!(bench.model.notices.visible()[0].text.contains("has not reached the robot"));
}

#[test]
fn answers_end_the_waiting_and_refusals_are_told() {
    let mut bench = Bench::connected();
    bench.command(ClientCommand::AllowMotion);
    let ids: Vec<_> = bench
        .take()
        .into_iter()
        .filter_map(|effect| match effect {
            ClientEffect::Send(ClientMessage::Command { id, .. }) => Some(id),
            _ => None,
        })
        .collect();
    assert_eq!(ids.len(), 2, "control was free, so it is taken first");
    for id in ids {
        let outcome = CommandOutcome::Refused("Not now. Wait until the robot stands.".into());
        bench.event(api::Event::CommandDone { id, outcome });
    }
    assert!(bench.model.pending.is_empty());
    let shown = bench.model.notices.visible();
    assert_eq!((shown.len(), shown[0].times), (1, 2), "the same sentence twice is one note");
}

#[test]
fn driving_repeats_ten_times_a_second_and_ends_with_one_zero() {
    let mut bench = Bench::connected();
    bench.event(api::Event::Control(Control { owner: Some(ME), name: String::new() }));
    let ahead = Twist { linear: Vec3::new(0.9, 0.0, 0.0), ..Twist::default() };
    for _ in 0..100 {
        bench.command(ClientCommand::SetVelocity(Some(ahead)));
        bench.wait(0.01);
    }
    let orders = bench.orders();
    assert!((9..=11).contains(&orders.len()), "{} orders in a second", orders.len());
    bench.command(ClientCommand::SetVelocity(None));
    bench.command(ClientCommand::SetVelocity(None));
    bench.wait(1.0);
    assert_eq!(bench.orders(), [Command::Teleoperate(Twist::default())]);
}

#[test]
fn walking_disarms_the_click_and_can_be_given_up() {
    let mut bench = Bench::connected();
    bench.event(api::Event::Control(Control { owner: Some(ME), name: String::new() }));
    bench.command(ClientCommand::PickGoal(true));
    bench.command(ClientCommand::WalkTo(Vec3::new(1.0, 2.0, 0.0)));
    assert!(!bench.model.walk_armed);
    bench.event(api::Event::Motion(Motion::Walking {
        goal: Vec3::default(),
        path: Vec::new(),
        remaining: 3.0,
    }));
    bench.take();
    bench.command(ClientCommand::CancelWalk);
    assert_eq!(bench.orders(), [Command::Teleoperate(Twist::default())]);
}

#[test]
fn who_shows_where_the_robot_stands_means_the_map_that_is_looked_at() {
    let mut bench = Bench::connected();
    bench.event(api::Event::Control(Control { owner: Some(ME), name: String::new() }));
    let map = MapId(Uuid::from_u128(7));
    let place = Pose { position: Vec3::new(3.0, 4.0, 0.5), ..Pose::IDENTITY };
    bench.command(ClientCommand::ViewMap(Some(map)));
    bench.command(ClientCommand::PickGoal(true));
    bench.command(ClientCommand::PickPose(true));
    assert!(bench.model.place_armed && !bench.model.walk_armed);
    bench.take();
    bench.command(ClientCommand::SetPose(place));
    assert_eq!(bench.orders(), [Command::Localise { map, at: Some(place) }]);
    assert_eq!((bench.model.place_armed, bench.model.viewed_map()), (false, None));
    bench.event(api::Event::Localisation(api::Localisation::Localised { map, doubt: None }));
    bench.command(ClientCommand::PickPose(true));
    bench.command(ClientCommand::PickGoal(true));
    assert!(bench.model.walk_armed && !bench.model.place_armed);
}

#[test]
fn a_file_that_was_chosen_is_sent_and_becomes_a_map_unless_it_is_given_up() {
    let mut bench = Bench::connected();
    let upload = UploadId(Uuid::from_u128(4));
    bench.command(ClientCommand::ImportMap { frame: None });
    assert!(bench.take().contains(&ClientEffect::OpenFileDialog));
    bench.apply(ClientEvent::UploadStarted { upload, file: "north.wing.laz".into() });
    bench.apply(ClientEvent::UploadProgress { upload, share: 0.25 });
    assert_eq!(bench.model.upload.as_ref().map(|it| it.share), Some(0.25));
    bench.apply(ClientEvent::UploadFinished { upload, result: Ok(()) });
    assert_eq!(bench.orders(), [Command::ImportMap { upload, name: "north.wing".into(), frame: None }]);
    assert_eq!(bench.model.upload, None);

    let (name, stage) = ("north.wing".to_owned(), api::ImportStage::Looking);
    bench.event(api::Event::Import(api::Import::Running { upload, name, stage, share: 0.5 }));
    bench.command(ClientCommand::CancelImport);
    assert_eq!(bench.orders(), [Command::CancelImport(upload)]);

    let frame = Some(MapId(Uuid::from_u128(7)));
    bench.command(ClientCommand::ImportMap { frame });
    bench.apply(ClientEvent::UploadStarted { upload, file: ".laz".into() });
    assert_eq!(bench.model.upload.as_ref().map(|it| it.frame), Some(frame));
    assert_eq!(bench.model.upload.as_ref().map(Upload::map_name), Some(".laz"));
    bench.command(ClientCommand::CancelImport);
    assert!(bench.take().contains(&ClientEffect::CancelUpload(upload)));
    bench.apply(ClientEvent::UploadFinished { upload, result: Err("late".into()) });
    assert!(bench.orders().is_empty() && bench.model.notices.visible().is_empty(), "nobody waits for it");
}

#[test]
fn points_are_picked_in_one_map_and_the_other_in_turn_and_may_be_taken_back() {
    let mut bench = Bench::connected();
    let [map, onto, third] = [1, 2, 3].map(|number| MapId(Uuid::from_u128(number)));
    let at = |x: f64| Vec3::new(x, 0.5 * x * x, 1.0);
    bench.command(ClientCommand::AlignMap { map, onto: None });
    bench.command(ClientCommand::AddAlignmentPoint(at(0.0)));
    assert!(bench.model.align.as_ref().is_some_and(|align| align.first.is_none()), "onto which?");
    bench.command(ClientCommand::AlignMap { map, onto: Some(onto) });
    for number in 0..2 {
        assert_eq!(bench.model.viewed_map(), Some(map));
        bench.command(ClientCommand::AddAlignmentPoint(at(f64::from(number))));
        assert_eq!(bench.model.viewed_map(), Some(onto));
        bench.command(ClientCommand::AddAlignmentPoint(at(f64::from(number) + 10.0)));
    }
    bench.command(ClientCommand::AddAlignmentPoint(at(9.0)));
    bench.command(ClientCommand::Undo);
    assert_eq!(bench.model.viewed_map(), Some(map));
    bench.command(ClientCommand::Undo);
    assert_eq!(bench.model.viewed_map(), Some(onto));
    let picked = bench.model.align.as_ref().map(|align| (align.picked_in(map), align.picked_in(onto)));
    assert_eq!(picked, Some((vec![at(0.0), at(1.0)], vec![at(10.0)])));
    bench.command(ClientCommand::ViewMap(Some(map)));
    bench.command(ClientCommand::AddAlignmentPoint(at(5.0)));
    assert!(bench.model.align.as_ref().is_some_and(|align| align.pairs.len() == 1), "its like is asked for");
    bench.command(ClientCommand::ViewMap(Some(onto)));
    bench.command(ClientCommand::AddAlignmentPoint(at(12.0)));
    bench.take();
    bench.command(ClientCommand::StartAlignment);
    let orders = bench.orders();
    let [Command::AlignMap { map: laid, onto: frame, pairs, .. }] = orders.as_slice() else {
        panic!("{orders:?}")
    };
    assert_eq!((*laid, *frame), (map, onto));
    assert_eq!(*pairs, [[at(0.0), at(10.0)], [at(1.0), at(12.0)]]);
    let work = bench.model.align.as_ref().and_then(|align| align.laying).expect("under way");
    bench.command(ClientCommand::AddAlignmentPoint(at(6.0)));
    bench.command(ClientCommand::Undo);
    let pairs = |bench: &Bench| bench.model.align.as_ref().map(|align| align.pairs.len());
    assert_eq!(pairs(&bench), Some(2), "nothing changes meanwhile");
    let reason = "It was cancelled.".to_owned();
    bench.event(api::Event::Import(api::Import::Failed { upload: work, name: String::new(), reason }));
    bench.take();
    bench.command(ClientCommand::StartAlignment);
    assert_eq!((pairs(&bench), bench.orders().len()), (Some(2), 1), "once more");
    let work = bench.model.align.as_ref().and_then(|align| align.laying).expect("under way");
    bench.event(api::Event::Import(api::Import::Done { upload: work, map: third }));
    assert_eq!(bench.model.align, None);

    bench.command(ClientCommand::AlignMap { map, onto: Some(onto) });
    bench.command(ClientCommand::ViewMap(Some(third)));
    assert_eq!(bench.model.align, None, "something else is looked at");
    bench.command(ClientCommand::AlignMap { map, onto: Some(onto) });
    bench.command(ClientCommand::CancelAlignment);
    assert_eq!((bench.model.align.as_ref(), bench.model.viewed_map()), (None, Some(map)));
}
