//! Routes, policies, closures, blocks and the place on the graph.

use super::*;
use crate::testing::{SiteBuilder, edge_id, node_id};
use proptest::prelude::*;
use site_model::{EdgeCost, EdgeId, LocalTime, NodeId, Object, Traversal, ZoneEffect};
use vocab::{Pose, Quat, Span, Stamp, Vec3};

fn graph(builder: &SiteBuilder) -> RouteGraph {
    RouteGraph::new(&builder.site(), &RouteConditions::default(), &RouteConfig::default())
}

/// 1 - 2 - 3 in a row of 7 m each, and a detour 1 - 4 - 3 of 30 m.
fn row_and_detour() -> SiteBuilder {
    let mut builder = SiteBuilder::new();
    for (number, x, y) in [(1, 0.0, 0.0), (2, 7.0, 0.0), (3, 14.0, 0.0), (4, 7.0, 13.3)] {
        builder.node(number, x, y);
    }
    builder.pair(1, 2).pair(2, 3).pair(1, 4).pair(4, 3);
    builder
}

#[test]
fn the_cheapest_route_and_the_policy_agree() {
    let graph = graph(&row_and_detour());
    let tree = graph.routes_to(node_id(3)).expect("a node");
    let route = tree.route(node_id(1)).expect("a route");
    assert_eq!(route.edges, [edge_id(1, 2), edge_id(2, 3)]);
    assert_eq!(route.nodes, [1, 2, 3].map(node_id));
    assert!((route.length_m - 14.0).abs() < 1e-9 && (route.cost_s - 20.0).abs() < 1e-5, "{route:?}");
    let policy = tree.policy();
    let next = |number| policy.get(&node_id(number)).copied();
    assert_eq!([1, 2, 3, 4].map(next), [Some(edge_id(1, 2)), Some(edge_id(2, 3)), None, Some(edge_id(4, 3))]);
    assert_eq!(tree.route(node_id(3)).expect("no route at all").edges, []);
}

#[test]
fn fixed_costs_stairs_and_learned_times_count() {
    let mut builder = row_and_detour();
    builder.change_edge(1, 2, |edge| edge.cost = EdgeCost::Fixed(100.0));
    let first = |builder: &SiteBuilder, learned: &LearnedTimes| {
        let conditions = RouteConditions { learned: Some(learned), ..RouteConditions::default() };
        let graph = RouteGraph::new(&builder.site(), &conditions, &RouteConfig::default());
        graph.routes_to(node_id(3)).expect("a node").route(node_id(1)).expect("a route").edges[0]
    };
    let mut learned = LearnedTimes::new();
    assert_eq!(first(&builder, &learned), edge_id(1, 4), "a fixed cost makes the detour cheaper");
    builder.change_edge(1, 2, |edge| edge.cost = EdgeCost::Learned);
    assert_eq!(first(&builder, &learned), edge_id(1, 2), "before the first traversal, the length counts");
    for _ in 0..3 {
        learned.entry(edge_id(1, 2)).or_default().add(90.0, &RouteConfig::default());
    }
    assert_eq!(first(&builder, &learned), edge_id(1, 4));
    builder.change_edge(1, 2, |edge| (edge.cost, edge.traversal) = (EdgeCost::Length, Traversal::Stairs));
    let stairs = graph(&builder).cost(edge_id(1, 2)).expect("an edge");
    assert!((stairs.0 - 7.0 / (0.7 * 0.33)).abs() < 1e-5, "{stairs:?}");
    builder.change_edge(1, 2, |edge| (edge.max_speed_m_s, edge.traversal) = (Some(0.35), Traversal::Walk));
    assert!((graph(&builder).cost(edge_id(1, 2)).expect("an edge").0 - 20.0).abs() < 1e-5);
}

#[test]
fn learned_times_have_mean_and_variance() {
    let mut learned = LearnedTime::default();
    for duration_s in [10.0, 12.0, 14.0] {
        learned.add(duration_s, &RouteConfig::default());
    }
    assert!((learned.mean_s - 12.0).abs() < 1e-9 && learned.count == 3);
    assert!((learned.variance_s2 - 8.0 / 3.0).abs() < 1e-9, "{learned:?}");
}

#[test]
fn no_route_names_what_blocks() {
    let mut builder = row_and_detour();
    builder.change_edge(2, 3, |edge| edge.is_enabled = false);
    let until = Stamp::from_nanos(60_000_000_000);
    let block =
        next_block(edge_id(4, 3), None, Stamp::EPOCH, "a trolley".to_owned(), &EdgeBlockConfig::default());
    assert_eq!(block.until, until);
    builder.put(Object::EdgeBlock(block.clone()));
    let graph = graph(&builder);
    let tree = graph.routes_to(node_id(3)).expect("a node");
    // The detour is longer, and both need one edge to open: the shorter one is named.
    assert_eq!(
        tree.route(node_id(1)),
        Err(NoRoute::Closed { edges: vec![(edge_id(2, 3), Closure::Disabled)] })
    );
    assert_eq!(
        tree.route(node_id(4)),
        Err(NoRoute::Closed { edges: vec![(edge_id(4, 3), Closure::Blocked(block))] })
    );
    builder.node(9, 50.0, 0.0);
    let apart = RouteGraph::new(&builder.site(), &RouteConditions::default(), &RouteConfig::default());
    let tree = apart.routes_to(node_id(9)).expect("a node");
    assert_eq!(tree.route(node_id(1)), Err(NoRoute::NotConnected));
    assert_eq!(tree.route(node_id(77)), Err(NoRoute::NoSuchNode(node_id(77))));
    // After the block has ended, the route is open.
    let later = RouteConditions { now: until, ..RouteConditions::default() };
    let open = RouteGraph::new(&builder.site(), &later, &RouteConfig::default());
    assert!(open.routes_to(node_id(3)).expect("a node").route(node_id(4)).is_ok());
}

#[test]
fn blocks_double_are_bounded_and_forgotten() {
    let config = EdgeBlockConfig::default();
    let mut now = Stamp::EPOCH;
    let mut block = next_block(edge_id(1, 2), None, now, String::new(), &config);
    let mut times_s = vec![60];
    for _ in 0..9 {
        now = block.until;
        block = next_block(edge_id(1, 2), Some(&block), now, String::new(), &config);
        times_s.push((block.until - now).nanos() / 1_000_000_000);
    }
    assert_eq!(times_s, [60, 120, 240, 480, 960, 1920, 3840, 7200, 7200, 7200]);
    assert!(is_blocked(&block, now) && !is_blocked(&block, block.until));
    let later = block.until + config.forget_after;
    assert_eq!(next_block(edge_id(1, 2), Some(&block), later, String::new(), &config).failures, 1);
}

#[test]
fn zones_close_slow_and_penalise() {
    let mut builder = row_and_detour();
    builder.zone(1, [[3.0, -1.0], [4.0, -1.0], [4.0, 1.0], [3.0, 1.0]], ZoneEffect::SpeedLimit(0.35), None);
    let cost = |builder: &SiteBuilder| graph(builder).cost(edge_id(1, 2)).expect("an edge").0;
    // 1 m of 7 at half the speed, by samples 0.25 m apart. The rest of the edge is walked as fast as before.
    assert!((cost(&builder) - 10.0 * 8.0 / 7.0).abs() < 0.4, "{}", cost(&builder));
    assert_eq!(graph(&builder).speed_m_s(edge_id(1, 2)), Some(0.7));
    builder.zone(1, [[3.0, -1.0], [4.0, -1.0], [4.0, 1.0], [3.0, 1.0]], ZoneEffect::Penalty(3.0), None);
    assert!((cost(&builder) - 10.0 * 9.0 / 7.0).abs() < 0.8, "{}", cost(&builder));
    let night = Some([LocalTime { hour: 22, minute: 0 }, LocalTime { hour: 6, minute: 0 }]);
    builder.zone(1, [[3.0, -1.0], [4.0, -1.0], [4.0, 1.0], [3.0, 1.0]], ZoneEffect::KeepOut, night);
    let is_closed = |hour| {
        let time_of_day = Some(LocalTime { hour, minute: 30 });
        let conditions = RouteConditions { time_of_day, ..RouteConditions::default() };
        let graph = RouteGraph::new(&builder.site(), &conditions, &RouteConfig::default());
        matches!(graph.closure(edge_id(1, 2)), Some(Closure::KeepOut(_)))
    };
    assert_eq!([5, 6, 12, 21, 22, 0].map(is_closed), [true, false, false, false, true, true]);
}

fn pose(x: f64, y: f64, yaw: f64) -> Pose {
    let orientation = Quat { w: (yaw / 2.0).cos(), x: 0.0, y: 0.0, z: (yaw / 2.0).sin() };
    Pose { position: Vec3::new(x, y, 0.0), orientation }
}

#[test]
fn at_nearest_and_on_edge_have_hysteresis() {
    let builder = row_and_detour();
    let (site, graph) = (builder.site(), graph(&builder));
    let mut localiser = GraphLocaliser::new(GraphLocaliserConfig::new(1.2));
    let mut place = |x: f64, y: f64, yaw: f64| localiser.update(&site, &graph, &pose(x, y, yaw));
    assert_eq!(place(0.05, 0.0, 0.02).at, Some(node_id(1)));
    assert_eq!(place(0.15, 0.0, 0.02).at, Some(node_id(1)), "a little beyond the tolerance");
    let left = place(0.25, 0.0, 0.02);
    assert_eq!((left.at, left.nearest, left.on), (None, Some(node_id(1)), Some(edge_id(1, 2))));
    assert_eq!(place(0.15, 0.0, 0.02).at, None, "it is at the node again within the tolerance only");
    // Halfway, the nearest node changes once and not back.
    assert_eq!(place(3.4, 0.1, 0.0).nearest, Some(node_id(1)));
    assert_eq!(place(3.6, 0.1, 0.0).nearest, Some(node_id(1)));
    assert_eq!(place(3.8, 0.1, 0.0).nearest, Some(node_id(2)));
    assert_eq!(place(3.4, 0.1, 0.0).nearest, Some(node_id(2)));
    // The robot turns round: it is on the other edge of the pair.
    assert_eq!(place(3.4, 0.1, 3.1).on, Some(edge_id(2, 1)));
    // Far from any edge.
    assert_eq!(place(3.4, -5.0, 0.0).on, None);
}

/// Cheapest costs by trying all simple paths.
fn brute_force(edges: &[(u128, u128, u32)], from: u128, to: u128, used: &mut Vec<u128>) -> Option<u32> {
    if from == to {
        return Some(0);
    }
    used.push(from);
    let mut best: Option<u32> = None;
    let steps = edges.iter().filter(|(a, b, _)| *a == from && !used.contains(b));
    for (b, cost) in steps.map(|(_, b, cost)| (*b, *cost)).collect::<Vec<_>>() {
        if let Some(rest) = brute_force(edges, b, to, used) {
            best = Some(best.map_or(cost + rest, |best| best.min(cost + rest)));
        }
    }
    used.pop();
    best
}

proptest! {
    #[test]
    fn routes_cost_as_much_as_the_best_of_all_paths(
        edges in proptest::collection::vec((1_u128..7, 1_u128..7, 1_u32..20), 0..18),
        from in 1_u128..7,
        to in 1_u128..7,
    ) {
        let mut builder = SiteBuilder::new();
        for number in 1..7 {
            builder.node(number, number as f64, 0.0);
        }
        let edges: Vec<_> = edges.into_iter().filter(|(a, b, _)| a != b).collect();
        for (index, (a, b, cost)) in edges.iter().enumerate() {
            builder.edge_of_cost(1_000 + index as u128, *a, *b, f64::from(*cost));
        }
        let graph = graph(&builder);
        let tree = graph.routes_to(node_id(to)).expect("a node");
        let expected = brute_force(&edges, from, to, &mut Vec::new());
        match tree.route(node_id(from)) {
            Ok(route) => {
                prop_assert_eq!(Some(route.cost_s.round() as u32), expected);
                prop_assert_eq!(tree.cost_s(node_id(from)).map(|cost| cost.round() as u32), expected);
                // The route follows the policy, and its edges join its nodes.
                let policy = tree.policy();
                for (index, edge) in route.edges.iter().enumerate() {
                    prop_assert_eq!(policy.get(&route.nodes[index]), Some(edge));
                }
                let ends: (Option<&NodeId>, Option<&NodeId>) = (route.nodes.first(), route.nodes.last());
                prop_assert_eq!(ends, (Some(&node_id(from)), Some(&node_id(to))));
            }
            Err(_) => prop_assert_eq!(expected, None),
        }
    }
}

#[test]
fn spans_of_blocks_are_those_of_the_config() {
    let config = EdgeBlockConfig { first: Span::from_millis(5), ..EdgeBlockConfig::default() };
    let block = next_block(EdgeId(uuid::Uuid::nil()), None, Stamp::EPOCH, String::new(), &config);
    assert_eq!(block.until, Stamp::from_nanos(5_000_000));
}
