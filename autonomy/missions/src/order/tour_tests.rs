//! Orders of tasks against all permutations.

use super::*;
use crate::graph::{RouteConditions, RouteConfig, RouteGraph};
use crate::testing::{SiteBuilder, node_id};
use proptest::prelude::*;
use site_model::{FailurePolicy, Mission, MissionEnd, MissionId, Task, TaskId, TaskOrder, TaskPlace};
use uuid::Uuid;

/// The cheapest permitted order of all.
fn brute_force(problem: &TourProblem) -> Option<f64> {
    fn extend(problem: &TourProblem, order: &mut Vec<usize>, best: &mut Option<f64>) {
        if order.len() == problem.len() {
            let cost = problem.cost(order);
            if problem.permits(order) && cost.is_finite() {
                *best = Some(best.map_or(cost, |best| best.min(cost)));
            }
            return;
        }
        for stop in 0..problem.len() {
            if !order.contains(&stop) {
                order.push(stop);
                extend(problem, order, best);
                order.pop();
            }
        }
    }
    let mut best = None;
    extend(problem, &mut Vec::new(), &mut best);
    best
}

fn cost() -> impl Strategy<Value = f64> {
    prop_oneof![9 => (0_u32..1000).prop_map(f64::from), 1 => Just(f64::INFINITY)]
}

/// Problems with costs that are not symmetric, walls, pinned stops and constraints, some of them contradictory.
fn problems(count: std::ops::Range<usize>) -> impl Strategy<Value = TourProblem> {
    count.prop_flat_map(|count| {
        let costs = || proptest::collection::vec(cost(), count);
        let stop = move || proptest::option::of(0..count.max(1));
        let pairs = proptest::collection::vec([0..count.max(1), 0..count.max(1)], 0..3);
        (costs(), proptest::collection::vec(costs(), count), costs(), stop(), stop(), pairs).prop_map(
            move |(from_start, between, to_end, first, last, before)| {
                let exists = |stop: Option<usize>| stop.filter(|stop| *stop < count);
                let (first, last) = (exists(first), exists(last));
                let before = if count == 0 { Vec::new() } else { before };
                TourProblem { from_start, between, to_end, first, last, before }
            },
        )
    })
}

proptest! {
    #[test]
    fn small_problems_are_solved_exactly(problem in problems(0..7)) {
        let expected = brute_force(&problem);
        match solve(&problem, &TourConfig::default()) {
            Ok(tour) => {
                prop_assert!(tour.is_exact && problem.permits(&tour.order));
                prop_assert_eq!(tour.order.len(), problem.len());
                prop_assert!((tour.cost - expected.unwrap_or(f64::NAN)).abs() < 1e-9, "{} {:?}", tour.cost, expected);
            }
            Err(TourError::Contradiction) => {
                let has_order = TourProblem {
                    from_start: vec![0.0; problem.len()],
                    between: vec![vec![0.0; problem.len()]; problem.len()],
                    to_end: vec![0.0; problem.len()],
                    ..problem.clone()
                };
                prop_assert_eq!(brute_force(&has_order), None);
            }
            Err(TourError::NotWalkable) => prop_assert_eq!(expected, None),
            Err(TourError::Malformed) => prop_assert!(false, "well-formed"),
        }
    }

    #[test]
    fn the_heuristic_keeps_the_constraints_and_is_never_better_than_the_best(problem in problems(0..8)) {
        let config = TourConfig { max_exact: 0, ..TourConfig::default() };
        let Ok(tour) = solve(&problem, &config) else { return Ok(()) };
        prop_assert!(problem.permits(&tour.order) && (!tour.is_exact || problem.is_empty()));
        let mut sorted = tour.order.clone();
        sorted.sort_unstable();
        prop_assert_eq!(sorted, (0..problem.len()).collect::<Vec<_>>());
        prop_assert!(tour.cost >= brute_force(&problem).unwrap_or(0.0) - 1e-9);
        prop_assert!((tour.cost - problem.cost(&tour.order)).abs() < 1e-9);
    }
}

/// Stops at random places of a square, with straight routes between them.
fn square(count: usize, seed: u64) -> TourProblem {
    let mut state = seed;
    let mut number = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / (1_u64 << 31) as f64 * 100.0
    };
    let places: Vec<(f64, f64)> = (0..count).map(|_| (number(), number())).collect();
    let distance = |a: (f64, f64), b: (f64, f64)| ((a.0 - b.0).powi(2) + (a.1 - b.1).powi(2)).sqrt();
    TourProblem {
        from_start: places.iter().map(|place| distance((0.0, 0.0), *place)).collect(),
        between: places.iter().map(|a| places.iter().map(|b| distance(*a, *b)).collect()).collect(),
        to_end: places.iter().map(|place| distance(*place, (0.0, 0.0))).collect(),
        ..TourProblem::default()
    }
}

#[test]
fn the_heuristic_is_close_to_the_best_and_better_than_the_list() {
    let heuristic = TourConfig { max_exact: 0, ..TourConfig::default() };
    let (mut worst, mut optimal) = (0.0_f64, 0);
    for seed in 0..60 {
        let problem = square(10, seed);
        let best = solve(&problem, &TourConfig::default()).expect("an order").cost;
        let found = solve(&problem, &heuristic).expect("an order").cost;
        worst = worst.max(found / best - 1.0);
        optimal += usize::from(found < best + 1e-9);
    }
    // docs/maths/tour.md quotes these figures.
    println!("10 stops, 60 squares: {optimal} optimal, worst {:.2} % longer", worst * 100.0);
    assert!(optimal >= 55 && worst < 0.05, "{optimal} of 60 optimal, worst {worst}");
    let problem = square(60, 7);
    let tour = solve(&problem, &TourConfig::default()).expect("an order");
    let listed = problem.cost(&(0..60).collect::<Vec<_>>());
    println!("60 stops: {:.0} m as listed, {:.0} m found", listed, tour.cost);
    assert!(!tour.is_exact && tour.cost < 0.25 * listed, "{} of {listed}", tour.cost);
    assert_eq!(tour, solve(&problem, &TourConfig::default()).expect("an order"), "the same again");
}

#[test]
fn what_cannot_be_ordered_is_reported() {
    let mut problem = square(4, 1);
    problem.before = vec![[0, 1], [1, 2], [2, 0]];
    assert_eq!(solve(&problem, &TourConfig::default()), Err(TourError::Contradiction));
    problem.before = vec![[1, 0]];
    problem.first = Some(0);
    assert_eq!(solve(&problem, &TourConfig::default()), Err(TourError::Contradiction));
    problem = square(3, 1);
    problem.to_end.pop();
    assert_eq!(solve(&problem, &TourConfig::default()), Err(TourError::Malformed));
    problem = square(3, 1);
    problem.from_start = vec![f64::INFINITY; 3];
    assert_eq!(solve(&problem, &TourConfig::default()), Err(TourError::NotWalkable));
}

pub(crate) fn mission(nodes: &[u128], order: TaskOrder, end: MissionEnd) -> Mission {
    let task = |(index, node): (usize, &u128)| Task {
        id: TaskId(Uuid::from_u128(500 + index as u128)),
        place: TaskPlace::Node { node: node_id(*node), request: None },
        on_unreachable: FailurePolicy::default(),
        on_action_failure: FailurePolicy::default(),
    };
    Mission {
        id: MissionId(Uuid::from_u128(400)),
        name: "Round".to_owned(),
        tasks: nodes.iter().enumerate().map(task).collect(),
        order,
        order_constraints: Vec::new(),
        end,
    }
}

#[test]
fn a_preview_has_both_routes_the_gain_and_what_cannot_be_reached() {
    // A corridor 1 - 2 - 3 - 4 of 7 m steps, with a node apart.
    let mut builder = SiteBuilder::new();
    for number in 1..=4 {
        builder.node(number, 7.0 * number as f64, 0.0);
    }
    builder.pair(1, 2).pair(2, 3).pair(3, 4).node(9, 100.0, 0.0);
    let site = builder.site();
    let graph = RouteGraph::new(&site, &RouteConditions::default(), &RouteConfig::default());
    let task = |index: u128| TaskId(Uuid::from_u128(500 + index));
    let shortest = TaskOrder::Shortest { keep_first: false, keep_last: false };
    let mut mission = mission(&[4, 9, 2, 3], shortest, MissionEnd::Node(node_id(1)));
    let config = TourConfig::default();
    let preview = order_tasks(&site, &graph, &mission, node_id(1), &config);
    assert_eq!(preview.unreachable, [task(1)]);
    assert_eq!(preview.order.last(), Some(&task(1)), "{preview:?}");
    // 21 + 14 + 7 + 14 as listed; there and back in the best order.
    let metres = |cost: Option<RouteCost>| cost.map(|cost| cost.length_m.round());
    assert_eq!((metres(preview.listed), metres(preview.chosen)), (Some(56.0), Some(42.0)));
    let gain = preview.gain().expect("both can be walked");
    assert!((gain.length_m - 14.0).abs() < 1e-6 && (gain.time_s - 20.0).abs() < 1e-3, "{gain:?}");
    assert!(preview.is_shortest);
    mission.order_constraints = vec![[task(0), task(2)], [task(3), task(0)]];
    assert_eq!(order_tasks(&site, &graph, &mission, node_id(1), &config).order, [3, 0, 2, 1].map(task));
    mission.order_constraints.clear();
    mission.order = TaskOrder::Shortest { keep_first: true, keep_last: true };
    assert_eq!(order_tasks(&site, &graph, &mission, node_id(1), &config).order, [0, 2, 3, 1].map(task));
    mission.order = TaskOrder::AsListed;
    let listed = order_tasks(&site, &graph, &mission, node_id(1), &config);
    assert_eq!((listed.order, listed.is_shortest), (vec![task(0), task(2), task(3), task(1)], false));
}
