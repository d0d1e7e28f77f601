//! Values: ages, the way, saved maps, notes, undo.

use super::*;
use api::LoopVerdict::Accepted;

#[test]
fn ages_count_from_the_robots_clock_and_from_arrival() {
    let mut bench = Bench::connected();
    let robot_now = Stamp::from_secs_f64(5000.0);
    bench.server(ServerMessage::Pong { token: 1, now: robot_now });
    bench.event(api::Event::Estimate(estimate_at(4998.0, 0.0)));
    let age = bench.model.data_age_s().unwrap();
    assert!((age - 2.0).abs() < 1e-6, "made 2 s ago by the robot's clock: {age}");
    bench.wait(3.0);
    let age = bench.model.data_age_s().unwrap();
    assert!((age - 5.0).abs() < 1e-6, "{age}");
}

#[test]
fn the_robots_clock_may_run_slower_than_ours() {
    let mut clock = ServerClock::default();
    for second in 0..5 {
        let here = ClientTime(f64::from(second));
        clock.learn(here, here, Stamp::EPOCH + Span::from_secs_f64(0.25 * f64::from(second)));
    }
    let later = clock.stamp_at(ClientTime(8.0)).unwrap().secs_f64();
    assert!((later - 2.0).abs() < 1e-6, "{later}");
}

#[test]
fn a_saved_map_is_shown_as_soon_as_it_is_written_and_the_live_one_with_the_next_session() {
    let mut bench = Bench::connected();
    let map = MapId(Uuid::from_u128(3));
    bench.event(api::Event::Mapping(Mapping::Saving { map }));
    bench.event(api::Event::Mapping(Mapping::Idle));
    assert_eq!(bench.model.viewed_map(), Some(map));
    assert!(bench.take().contains(&ClientEffect::LoadMap(map)));
    bench.apply(ClientEvent::TilesListed {
        map,
        result: Ok(TileList { bounds: Aabb::EMPTY, tiles: vec![tile(1, 0, 0.0, 9)], robust_bounds: None }),
    });
    assert_eq!(bench.model.displayed_map().tiles.points(), 9);
    assert!(bench.take().contains(&ClientEffect::MoveCamera(CameraMove::Fit)), "one sees all of it first");
    bench.event(api::Event::Mapping(Mapping::Starting { session: SessionId(Uuid::from_u128(1)) }));
    assert_eq!(bench.model.viewed_map(), None);
}

#[test]
fn a_snapshot_that_is_idle_shows_the_live_map() {
    let mut bench = Bench::connected();
    bench.event(api::Event::Mapping(Mapping::Idle));
    assert_eq!(bench.model.viewed_map(), None);
}

#[test]
fn what_was_walked_before_the_robot_found_itself_in_a_map_is_forgotten() {
    let mut bench = Bench::connected();
    let map = MapId(Uuid::from_u128(3));
    let way = |bench: &Bench| bench.model.trajectory().count();
    for step in 0..10 {
        bench.event(api::Event::Estimate(estimate_at(f64::from(step), f64::from(step))));
    }
    bench.event(api::Event::Localisation(api::Localisation::Relocalising { map, places: 2 }));
    assert!(!bench.model.has_pose_in_map(), "it is drawn nowhere");
    bench.event(api::Event::Estimate(estimate_at(10.0, 10.0)));
    bench.event(api::Event::Localisation(api::Localisation::Localised { map, doubt: None }));
    assert_eq!(way(&bench), 0);
    for step in 11..15 {
        bench.event(api::Event::Estimate(estimate_at(f64::from(step), f64::from(step))));
    }
    let walked = way(&bench);
    let doubt = Some(api::Doubt::Dark);
    bench.event(api::Event::Localisation(api::Localisation::Localised { map, doubt }));
    assert!(walked > 2 && way(&bench) == walked, "a doubt forgets nothing");
    bench.event(api::Event::Localisation(api::Localisation::Relocalising { map, places: 0 }));
    assert!(bench.model.has_pose_in_map(), "where it was last is better than nothing");
    bench.event(api::Event::Localisation(api::Localisation::Loading { map: MapId(Uuid::from_u128(4)) }));
    assert!(!bench.model.has_pose_in_map());
}

#[test]
fn the_way_follows_corrections_of_the_graph() {
    let mut bench = Bench::connected();
    for step in 0..30 {
        bench.event(api::Event::Estimate(estimate_at(f64::from(step), f64::from(step))));
    }
    let moved = Pose { position: Vec3::new(19.0, 5.0, 0.0), ..Pose::IDENTITY };
    let node = GraphNode { id: KeyframeId(0), stamp: Stamp::from_secs_f64(19.5), map_from_keyframe: moved };
    bench.event(api::Event::Graph(Graph { nodes: vec![node], ..Graph::default() }));
    let way: Vec<Vec3> = bench.model.trajectory().collect();
    assert_eq!(way.len(), 11, "the keyframe, then what was seen since");
    assert_eq!((way[0].y, way[1].x), (5.0, 20.0));
}

#[test]
fn decisions_on_loops_add_up_until_another_session_and_the_oldest_go() {
    let mut bench = Bench::connected();
    let mut tell = |reset, added: std::ops::Range<u32>| {
        bench.event(api::Event::Loops(api::LoopsChanged {
            reset,
            added: added.map(|to| decided(0, to, Accepted)).collect(),
        }));
        let loops = &bench.model.loops;
        (loops.latest().last().map(|decision| decision.to.0), loops.len())
    };
    assert_eq!(tell(true, 0..2), (Some(0), 2));
    assert_eq!(tell(false, 2..3), (Some(0), 3));
    let most = api::MAX_LOOP_DECISIONS;
    assert_eq!(tell(false, 3..most as u32 + 5), (Some(5), most));
    assert_eq!(tell(true, 0..0), (None, 0));
}

#[test]
fn edits_of_the_view_are_kept_undone_and_merged_while_a_slider_is_dragged() {
    let mut bench = Bench::connected();
    bench.now = bench.now.after(10.0);
    for step in 0..10_u8 {
        bench.now = bench.now.after(0.05);
        let settings = ViewSettings { ceiling_m: f32::from(step), ..ViewSettings::default() };
        bench.command(ClientCommand::EditView(settings));
    }
    assert!(
        matches!(bench.take().last(), Some(ClientEffect::SaveSettings(settings)) if settings.ceiling_m == 9.0)
    );
    bench.command(ClientCommand::Undo);
    assert_eq!(bench.model.view_settings(), &ViewSettings::default(), "one drag is one step");
    bench.command(ClientCommand::Redo);
    assert_eq!(bench.model.view_settings().ceiling_m, 9.0);
}

#[test]
fn a_notice_from_before_is_no_news_when_the_snapshot_repeats_it() {
    let mut bench = Bench::connected();
    for (secs, text) in [(100.0, "old"), (4999.0, "new")] {
        let at = Stamp::from_secs_f64(secs);
        bench.event(api::Event::Notice(api::Notice { at, severity: api::Severity::Info, text: text.into() }));
    }
    assert!(bench.model.notices.visible().is_empty(), "nobody knows yet how old they are");
    bench.server(ServerMessage::Pong { token: 1, now: Stamp::from_secs_f64(5000.0) });
    let shown: Vec<&str> = bench.model.notices.visible().iter().map(|note| note.text.as_str()).collect();
    assert_eq!(shown, ["new"]);
}

#[test]
fn errors_stay_until_they_are_put_away_and_the_rest_goes_by_itself() {
    let mut bench = Bench::connected();
    bench.server(ServerMessage::Pong { token: 1, now: Stamp::EPOCH });
    for (severity, text) in [(api::Severity::Info, "saved"), (api::Severity::Error, "LiDAR silent")] {
        let notice = api::Notice { at: Stamp::EPOCH, severity, text: text.into() };
        bench.event(api::Event::Notice(notice));
    }
    for _ in 0..30 {
        bench.wait(1.0);
        bench.server(ServerMessage::Pong { token: 0, now: Stamp::EPOCH });
    }
    let left: Vec<&str> = bench.model.notices.visible().iter().map(|note| note.text.as_str()).collect();
    assert_eq!(left, ["LiDAR silent"]);
    let id = bench.model.notices.visible()[0].id;
    bench.command(ClientCommand::DismissNotice(id));
    assert!(bench.model.notices.visible().is_empty());
}
