//! Which tiles are fetched, and that the counts hold whatever comes; undo as a law.

use super::*;

#[test]
fn the_coarsest_tiles_come_first_and_few_at_a_time() {
    let mut bench = Bench::connected();
    let mut tiles: Vec<TileEntry> = (0..20).map(|i| tile(i + 10, 2, 2.0 * f32::from(i), 1000)).collect();
    tiles.push(tile(1, 0, 0.0, 1000));
    bench.event(api::Event::Tiles(TilesChanged { reset: true, added: tiles }));
    bench.apply(ClientEvent::ViewpointChanged(eye_at(-3.0)));
    let fetches: Vec<TileHash> = bench
        .take()
        .into_iter()
        .filter_map(|effect| match effect {
            ClientEffect::FetchTile(hash) => Some(hash),
            _ => None,
        })
        .collect();
    assert_eq!(fetches.len(), TILE_REQUESTS_MAX);
    assert_eq!(fetches[0], TileHash([1; 32]), "coarse first");
    assert_eq!(fetches[1], TileHash([10; 32]), "then the nearest");
}

#[test]
fn an_eye_that_comes_before_the_tiles_keeps_none_waiting() {
    let mut bench = Bench::connected();
    bench.apply(ClientEvent::ViewpointChanged(eye_at(-3.0)));
    assert!(!bench.model.displayed_map().tiles.listed());
    bench.event(api::Event::Tiles(TilesChanged { reset: true, added: vec![tile(1, 0, 0.0, 10)] }));
    assert!(
        bench.take().iter().any(|effect| matches!(effect, ClientEffect::FetchTile(_))),
        "at once, not a period later"
    );
    assert!(bench.model.displayed_map().tiles.listed());
}

#[test]
fn tiles_no_longer_wanted_are_cancelled_and_others_fetched() {
    let mut bench = Bench::connected();
    let near: Vec<TileEntry> = (0..8).map(|i| tile(i + 10, 5, f32::from(i), 1000)).collect();
    let far: Vec<TileEntry> = (0..8).map(|i| tile(i + 50, 5, 900.0 + f32::from(i), 1000)).collect();
    bench.event(api::Event::Tiles(TilesChanged { reset: true, added: [near, far].concat() }));
    bench.apply(ClientEvent::ViewpointChanged(eye_at(-1.0)));
    bench.take();
    bench.now = bench.now.after(1.0);
    bench.apply(ClientEvent::ViewpointChanged(eye_at(899.0)));
    let effects = bench.take();
    let cancelled = effects.iter().filter(|effect| matches!(effect, ClientEffect::CancelTile(_))).count();
    let fetched = |effect: &&ClientEffect| matches!(effect, ClientEffect::FetchTile(hash) if hash.0[0] >= 50);
    assert_eq!((cancelled, effects.iter().filter(fetched).count()), (TILE_REQUESTS_MAX, TILE_REQUESTS_MAX));
}

#[test]
fn a_tile_that_cannot_be_had_is_tried_again_later_a_few_times() {
    let mut bench = Bench::connected();
    bench.event(api::Event::Tiles(TilesChanged { reset: true, added: vec![tile(1, 0, 0.0, 10)] }));
    bench.apply(ClientEvent::ViewpointChanged(eye_at(-3.0)));
    let mut tries = 0;
    for _ in 0..600 {
        for effect in bench.take() {
            if let ClientEffect::FetchTile(hash) = effect {
                tries += 1;
                bench.apply(ClientEvent::TileFailed { hash });
            }
        }
        bench.wait(0.5);
    }
    assert_eq!(tries, 5);
}

#[test]
fn tiles_of_keyframes_wait_for_their_pose() {
    let mut bench = Bench::connected();
    let anchored = TileEntry { anchor: Anchor::Keyframe(KeyframeId(4)), ..tile(1, 0, 0.0, 10) };
    bench.event(api::Event::Tiles(TilesChanged { reset: true, added: vec![anchored] }));
    bench.apply(ClientEvent::ViewpointChanged(eye_at(-3.0)));
    assert!(!bench.take().iter().any(|effect| matches!(effect, ClientEffect::FetchTile(_))));
    let node = GraphNode { id: KeyframeId(4), ..GraphNode::default() };
    bench.now = bench.now.after(1.0);
    bench.event(api::Event::Graph(Graph { nodes: vec![node], ..Graph::default() }));
    assert!(bench.take().iter().any(|effect| matches!(effect, ClientEffect::FetchTile(_))));
}

proptest! {
    /// Whatever comes, fetches under way stay few, counts agree with states, and nothing panics.
    #[test]
    fn tile_counts_hold(steps in proptest::collection::vec((0_u8..6, 0_u8..30), 0..200)) {
        let mut bench = Bench::connected();
        let mut loading = std::collections::BTreeSet::new();
        for (what, number) in steps {
            let hash = TileHash([number; 32]);
            match what {
                0 => bench.event(api::Event::Tiles(TilesChanged {
                    reset: number == 0,
                    added: vec![tile(number, number % 4, f32::from(number), 300_000)],
                })),
                1 => bench.apply(ClientEvent::ViewpointChanged(eye_at(f64::from(number)))),
                2 if loading.contains(&hash) => bench.apply(ClientEvent::TileReady { hash, bytes: 1 }),
                3 if loading.contains(&hash) => bench.apply(ClientEvent::TileFailed { hash }),
                4 => bench.command(ClientCommand::ViewMap((number < 3).then_some(MapId(Uuid::from_u128(1))))),
                _ => bench.wait(0.3),
            }
            if what == 2 || what == 3 {
                loading.remove(&hash);
            }
            for effect in bench.take() {
                match effect {
                    ClientEffect::FetchTile(hash) => { prop_assert!(loading.insert(hash), "fetched twice"); }
                    ClientEffect::CancelTile(hash) => { prop_assert!(loading.remove(&hash), "cancelled without a fetch"); }
                    _ => {}
                }
            }
            prop_assert!(loading.len() <= TILE_REQUESTS_MAX);
            prop_assert_eq!(bench.model.displayed_map().tiles.loading(), loading.len());
            prop_assert!(bench.model.displayed_map().tiles.ready_points() <= TILE_POINTS_MAX);
        }
    }

    /// Undo and redo are inverse.
    #[test]
    fn undo_then_redo_changes_nothing(values in proptest::collection::vec(0_u32..5, 1..40)) {
        let mut undo = Undo::new(0_u32);
        for (at, value) in values.iter().enumerate() {
            undo.set(ClientTime(at as f64), *value);
        }
        let last = *undo.get();
        let mut steps = 0;
        while undo.undo() { steps += 1; }
        prop_assert_eq!(*undo.get(), 0);
        for _ in 0..steps { prop_assert!(undo.redo()); }
        prop_assert_eq!(*undo.get(), last);
        prop_assert!(!undo.can_redo());
    }
}
