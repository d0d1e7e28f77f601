//! Orders: ids, repetition, answers, driving.

use super::*;

#[test]
fn an_unanswered_order_is_repeated_under_its_id_after_a_short_loss() {
    let mut bench = Bench::connected();
    bench.event(api::Event::Control(Control { owner: Some(ME), name: String::new() }));
    bench.command(Command::StartMapping);
    let first = bench.take();
    assert!(matches!(&first[..], [Effect::Send(ClientMessage::Command { .. })]), "{first:?}");
    lose(&mut bench);
    bench.wait(1.0);
    bench.take();
    bench.connect();
    let again = bench.take();
    assert!(again.contains(&first[0]), "the same command under the same id");
    assert!(bench.model.waits_for(|order| matches!(order, Order::StartMapping(_))));
}

#[test]
fn an_old_order_is_not_repeated_but_told() {
    let mut bench = Bench::connected();
    bench.command(Command::WalkTo(Vec3::default()));
    lose(&mut bench);
    bench.wait(60.0);
    bench.take();
    bench.connect();
    assert_eq!(bench.orders(), []);
    let notes = bench.model.notes.shown();
    assert!(notes.iter().any(|note| note.text.contains("Walking there may not have reached")), "{notes:?}");
}

#[test]
fn a_stop_is_sent_even_an_hour_later_and_needs_no_control() {
    let mut bench = Bench::connected();
    bench.event(api::Event::Control(Control { owner: Some(OTHER), name: "other".into() }));
    bench.command(Command::StopMotion);
    assert_eq!(bench.orders(), [Order::StopMotion]);
    lose(&mut bench);
    bench.wait(3600.0);
    bench.connect();
    assert_eq!(bench.orders(), [Order::StopMotion]);
}

#[test]
fn a_stop_without_a_link_says_that_it_did_not_arrive() {
    let mut bench = Bench::new();
    bench.command(Command::StopMotion);
    assert!(bench.model.notes.shown()[0].text.contains("has not reached the robot"));
}

#[test]
fn answers_end_the_waiting_and_refusals_are_told() {
    let mut bench = Bench::connected();
    bench.command(Command::AllowMotion);
    let ids: Vec<_> = bench
        .take()
        .into_iter()
        .filter_map(|effect| match effect {
            Effect::Send(ClientMessage::Command { id, .. }) => Some(id),
            _ => None,
        })
        .collect();
    assert_eq!(ids.len(), 2, "control was free, so it is taken first");
    for id in ids {
        let outcome = CommandOutcome::Refused("Not now. Wait until the robot stands.".into());
        bench.event(api::Event::CommandDone { id, outcome });
    }
    assert!(bench.model.pending.is_empty());
    let shown = bench.model.notes.shown();
    assert_eq!((shown.len(), shown[0].times), (1, 2), "the same sentence twice is one note");
}

#[test]
fn driving_repeats_ten_times_a_second_and_ends_with_one_zero() {
    let mut bench = Bench::connected();
    bench.event(api::Event::Control(Control { owner: Some(ME), name: String::new() }));
    let ahead = Twist { linear: Vec3::new(0.9, 0.0, 0.0), ..Twist::default() };
    for _ in 0..100 {
        bench.command(Command::Drive(Some(ahead)));
        bench.wait(0.01);
    }
    let orders = bench.orders();
    assert!((9..=11).contains(&orders.len()), "{} orders in a second", orders.len());
    bench.command(Command::Drive(None));
    bench.command(Command::Drive(None));
    bench.wait(1.0);
    assert_eq!(bench.orders(), [Order::Teleoperate(Twist::default())]);
}

#[test]
fn walking_disarms_the_click_and_can_be_given_up() {
    let mut bench = Bench::connected();
    bench.event(api::Event::Control(Control { owner: Some(ME), name: String::new() }));
    bench.command(Command::ArmWalk(true));
    bench.command(Command::WalkTo(Vec3::new(1.0, 2.0, 0.0)));
    assert!(!bench.model.walk_armed);
    bench.event(api::Event::Motion(Motion::Walking {
        goal: Vec3::default(),
        path: Vec::new(),
        remaining: 3.0,
    }));
    bench.take();
    bench.command(Command::CancelWalk);
    assert_eq!(bench.orders(), [Order::Teleoperate(Twist::default())]);
}

#[test]
fn who_shows_where_the_robot_stands_means_the_map_that_is_looked_at() {
    let mut bench = Bench::connected();
    bench.event(api::Event::Control(Control { owner: Some(ME), name: String::new() }));
    let map = MapId(Uuid::from_u128(7));
    let place = Pose { position: Vec3::new(3.0, 4.0, 0.5), ..Pose::IDENTITY };
    bench.command(Command::ViewMap(Some(map)));
    bench.command(Command::ArmWalk(true));
    bench.command(Command::ArmPlace(true));
    assert!(bench.model.place_armed && !bench.model.walk_armed);
    bench.take();
    bench.command(Command::PlaceRobot(place));
    assert_eq!(bench.orders(), [Order::Localise { map, at: Some(place) }]);
    assert_eq!((bench.model.place_armed, bench.model.viewed()), (false, None));
    bench.event(api::Event::Localisation(api::Localisation::Localised { map, doubt: None }));
    bench.command(Command::ArmPlace(true));
    bench.command(Command::ArmWalk(true));
    assert!(bench.model.walk_armed && !bench.model.place_armed);
}

#[test]
fn a_file_that_was_chosen_is_sent_and_becomes_a_map_unless_it_is_given_up() {
    let mut bench = Bench::connected();
    let upload = UploadId(Uuid::from_u128(4));
    bench.command(Command::PickMapFile { frame: None });
    assert!(bench.take().contains(&Effect::PickFile));
    bench.apply(Event::UploadBegun { upload, file: "north.wing.laz".into() });
    bench.apply(Event::Uploading { upload, share: 0.25 });
    assert_eq!(bench.model.upload.as_ref().map(|it| it.share), Some(0.25));
    bench.apply(Event::Uploaded { upload, result: Ok(()) });
    assert_eq!(bench.orders(), [Order::ImportMap { upload, name: "north.wing".into(), frame: None }]);
    assert_eq!(bench.model.upload, None);

    let (name, stage) = ("north.wing".to_owned(), api::ImportStage::Looking);
    bench.event(api::Event::Import(api::Import::Running { upload, name, stage, share: 0.5 }));
    bench.command(Command::CancelImport);
    assert_eq!(bench.orders(), [Order::CancelImport(upload)]);

    let frame = Some(MapId(Uuid::from_u128(7)));
    bench.command(Command::PickMapFile { frame });
    bench.apply(Event::UploadBegun { upload, file: ".laz".into() });
    assert_eq!(bench.model.upload.as_ref().map(|it| it.frame), Some(frame));
    assert_eq!(bench.model.upload.as_ref().map(Upload::map_name), Some(".laz"));
    bench.command(Command::CancelImport);
    assert!(bench.take().contains(&Effect::CancelUpload(upload)));
    bench.apply(Event::Uploaded { upload, result: Err("late".into()) });
    assert!(bench.orders().is_empty() && bench.model.notes.shown().is_empty(), "nobody waits for it");
}

#[test]
fn points_are_picked_in_one_map_and_the_other_in_turn_and_may_be_taken_back() {
    let mut bench = Bench::connected();
    let [map, onto, third] = [1, 2, 3].map(|number| MapId(Uuid::from_u128(number)));
    let at = |x: f64| Vec3::new(x, 0.5 * x * x, 1.0);
    bench.command(Command::Align { map, onto: None });
    bench.command(Command::PickPoint(at(0.0)));
    assert!(bench.model.align.as_ref().is_some_and(|align| align.first.is_none()), "onto which?");
    bench.command(Command::Align { map, onto: Some(onto) });
    for number in 0..2 {
        assert_eq!(bench.model.viewed(), Some(map));
        bench.command(Command::PickPoint(at(f64::from(number))));
        assert_eq!(bench.model.viewed(), Some(onto));
        bench.command(Command::PickPoint(at(f64::from(number) + 10.0)));
    }
    bench.command(Command::PickPoint(at(9.0)));
    bench.command(Command::Undo);
    assert_eq!(bench.model.viewed(), Some(map));
    bench.command(Command::Undo);
    assert_eq!(bench.model.viewed(), Some(onto));
    let picked = bench.model.align.as_ref().map(|align| (align.picked_in(map), align.picked_in(onto)));
    assert_eq!(picked, Some((vec![at(0.0), at(1.0)], vec![at(10.0)])));
    bench.command(Command::ViewMap(Some(map)));
    bench.command(Command::PickPoint(at(5.0)));
    assert!(bench.model.align.as_ref().is_some_and(|align| align.pairs.len() == 1), "its like is asked for");
    bench.command(Command::ViewMap(Some(onto)));
    bench.command(Command::PickPoint(at(12.0)));
    bench.take();
    bench.command(Command::Lay);
    let orders = bench.orders();
    let [Order::AlignMap { map: laid, onto: frame, pairs, .. }] = orders.as_slice() else {
        panic!("{orders:?}")
    };
    assert_eq!((*laid, *frame), (map, onto));
    assert_eq!(*pairs, [[at(0.0), at(10.0)], [at(1.0), at(12.0)]]);
    let work = bench.model.align.as_ref().and_then(|align| align.laying).expect("under way");
    bench.command(Command::PickPoint(at(6.0)));
    bench.command(Command::Undo);
    let pairs = |bench: &Bench| bench.model.align.as_ref().map(|align| align.pairs.len());
    assert_eq!(pairs(&bench), Some(2), "nothing changes meanwhile");
    let reason = "It was cancelled.".to_owned();
    bench.event(api::Event::Import(api::Import::Failed { upload: work, name: String::new(), reason }));
    bench.take();
    bench.command(Command::Lay);
    assert_eq!((pairs(&bench), bench.orders().len()), (Some(2), 1), "once more");
    let work = bench.model.align.as_ref().and_then(|align| align.laying).expect("under way");
    bench.event(api::Event::Import(api::Import::Done { upload: work, map: third }));
    assert_eq!(bench.model.align, None);

    bench.command(Command::Align { map, onto: Some(onto) });
    bench.command(Command::ViewMap(Some(third)));
    assert_eq!(bench.model.align, None, "something else is looked at");
    bench.command(Command::Align { map, onto: Some(onto) });
    bench.command(Command::CancelAlign);
    assert_eq!((bench.model.align.as_ref(), bench.model.viewed()), (None, Some(map)));
}
