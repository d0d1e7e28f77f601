//! The travelling-salesperson path: the cheapest order of stops from a start to an end. `docs/maths/tour.md` has the
//! equations; docstrings name them by number.

use super::tour_heuristic;
use super::tour_problem::{Tour, TourConfig, TourError, TourProblem};

/// The cheapest order: exactly up to [`TourConfig::max_exact`] stops, by a heuristic above. The same problem always has the same answer.
///
/// # Errors
/// Why there is no order.
pub fn solve(problem: &TourProblem, config: &TourConfig) -> Result<Tour, TourError> {
    if !problem.is_well_formed() {
        return Err(TourError::Malformed);
    }
    if problem.is_empty() {
        return Ok(Tour { order: Vec::new(), cost: 0.0, is_exact: true });
    }
    let predecessors = problem.predecessors();
    if !can_be_ordered(&predecessors) {
        return Err(TourError::Contradiction);
    }
    // The bits of 64-bit sets bound what can be solved exactly.
    let is_exact = problem.len() <= config.max_exact.min(20);
    let order = match is_exact {
        true => held_karp(problem, &predecessors),
        false => tour_heuristic::find_order(problem, &predecessors, config),
    };
    let order = order.ok_or(TourError::NotWalkable)?;
    let cost = problem.cost(&order);
    if cost.is_finite() { Ok(Tour { order, cost, is_exact }) } else { Err(TourError::NotWalkable) }
}

/// Whether every stop can be put after its predecessors.
fn can_be_ordered(predecessors: &[Vec<usize>]) -> bool {
    let mut is_placed = vec![false; predecessors.len()];
    for _ in 0..predecessors.len() {
        let is_free =
            |&stop: &usize| !is_placed[stop] && predecessors[stop].iter().all(|&other| is_placed[other]);
        match (0..predecessors.len()).find(is_free) {
            Some(stop) => is_placed[stop] = true,
            None => return false,
        }
    }
    true
}

/// The algorithm of Held and Karp (equation 2). `n² 2ⁿ` steps and `n 2ⁿ` numbers. None if every order has an infinite cost.
fn held_karp(problem: &TourProblem, predecessors: &[Vec<usize>]) -> Option<Vec<usize>> {
    let count = problem.len();
    let sets = 1_usize << count;
    let needed: Vec<usize> =
        predecessors.iter().map(|stops| stops.iter().fold(0, |set, stop| set | 1 << stop)).collect();
    // Least cost from the start over all stops of a set, with one of them as the last.
    let mut costs = vec![f64::INFINITY; sets * count];
    let mut previous = vec![u8::MAX; sets * count];
    for stop in (0..count).filter(|&stop| needed[stop] == 0) {
        costs[(1 << stop) * count + stop] = problem.from_start[stop];
    }
    for set in 1..sets {
        for last in (0..count).filter(|last| set & (1 << last) != 0) {
            let cost = costs[set * count + last];
            if cost.is_infinite() {
                continue;
            }
            for next in (0..count).filter(|&next| set & (1 << next) == 0 && needed[next] & !set == 0) {
                let (index, longer) = ((set | 1 << next) * count + next, cost + problem.between[last][next]);
                if longer < costs[index] {
                    costs[index] = longer;
                    previous[index] = last as u8;
                }
            }
        }
    }
    let all = sets - 1;
    let total = |last: usize| costs[all * count + last] + problem.to_end[last];
    let mut last = (0..count).min_by(|&a, &b| total(a).total_cmp(&total(b)))?;
    if total(last).is_infinite() {
        return None;
    }
    let (mut order, mut set) = (vec![last], all);
    while order.len() < count {
        let before = usize::from(previous[set * count + last]);
        set &= !(1 << last);
        last = before;
        order.push(last);
    }
    order.reverse();
    Some(order)
}
