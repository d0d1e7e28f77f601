//! Imported surveys: bounds without stray points, and no pose graph.

use super::*;
use api::MapSummary;

const SURVEY: MapId = MapId(Uuid::from_u128(5));

fn summary(has_pose_graph: bool) -> MapSummary {
    MapSummary {
        id: SURVEY,
        name: "Survey".into(),
        created: Stamp::from_secs_f64(1.0),
        distance: 0.0,
        keyframes: 438,
        points: 2_000_000,
        bytes: 40_000_000,
        has_pose_graph,
    }
}

/// A client that views a map whose server lists these tiles.
fn viewing(summary: MapSummary, list: TileList) -> Bench {
    let mut bench = Bench::connected();
    bench.event(api::Event::Maps(vec![summary]));
    bench.command(ClientCommand::ViewMap(Some(SURVEY)));
    bench.apply(ClientEvent::TilesListed { map: SURVEY, result: Ok(list) });
    bench
}

fn boxed(min: [f32; 3], max: [f32; 3], points: u32, name: u8) -> TileEntry {
    TileEntry { bounds: Aabb { min, max }, points, ..tile(name, 1, 0.0, points) }
}

#[test]
fn the_virtual_viewpoints_of_a_survey_are_no_pose_graph() {
    assert!(Bench::connected().model.has_pose_graph(), "a live session");
    for walked in [true, false] {
        let bench = viewing(summary(walked), TileList::default());
        assert_eq!(bench.model.has_pose_graph(), walked);
    }
}

#[test]
fn the_bounds_of_a_survey_are_the_servers_else_those_of_its_tiles_without_strays() {
    let tiles = vec![
        boxed([0.0; 3], [30.0, 20.0, 5.0], 1_000_000, 1),
        boxed([400.0, 300.0, 80.0], [402.0, 302.0, 82.0], 40, 2),
    ];
    let list = TileList { tiles, ..TileList::default() };
    let bounds = viewing(summary(false), list.clone()).model.displayed_map().robust_bounds().unwrap();
    assert!(bounds.max[0] < 31.0 && bounds.max[1] < 21.0 && bounds.max[2] < 6.0, "{bounds:?}");
    let listed = Aabb { min: [1.0; 3], max: [2.0; 3] };
    let list = TileList { robust_bounds: Some(listed), ..list };
    assert_eq!(viewing(summary(false), list).model.displayed_map().robust_bounds(), Some(listed));
}
