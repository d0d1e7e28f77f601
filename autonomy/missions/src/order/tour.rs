//! The travelling-salesperson path: the cheapest order of stops from a start to an end. `docs/maths/tour.md` has the equations.

use super::tour_heuristic;

/// Parameters of [`solve`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TourConfig {
    /// Greatest number of stops that is solved exactly. Time and memory double with each more; 12 take milliseconds.
    pub exact_max: usize,
    /// Greatest number of starts of the heuristic. More starts find better orders in proportion to the time.
    pub starts_max: usize,
    /// Greatest number of improvements after each start: a bound on the time, never reached in tests with 60 stops.
    pub improvements_max: usize,
}

impl Default for TourConfig {
    fn default() -> Self {
        Self { exact_max: 12, starts_max: 12, improvements_max: 2_000 }
    }
}

/// Stops to be put in order. All costs are at least 0; infinite ones cannot be walked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TourProblem {
    /// From the start to each stop.
    pub from_start: Vec<f64>,
    /// From stop (row) to stop (column). It need not be symmetric.
    pub between: Vec<Vec<f64>>,
    /// From each stop to the end; 0 if the tour ends anywhere.
    pub to_end: Vec<f64>,
    /// The stop that stays the first.
    pub first: Option<usize>,
    /// The stop that stays the last.
    pub last: Option<usize>,
    /// Pairs of stops of which the first comes before the second.
    pub before: Vec<[usize; 2]>,
}

/// An order of stops.
#[derive(Clone, Debug, PartialEq)]
pub struct Tour {
    /// All stops.
    pub order: Vec<usize>,
    /// Sum of the costs from start to end.
    pub cost: f64,
    /// Whether no order is cheaper. Otherwise a heuristic has found it.
    pub is_exact: bool,
}

/// Why there is no order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TourError {
    /// The constraints contradict each other, or the first and the last stop.
    #[error("no order meets all constraints")]
    Contradiction,
    /// Every order has an infinite cost.
    #[error("no order can be walked")]
    NotWalkable,
    /// The tables do not have the same size, or a stop does not exist.
    #[error("the tables of costs do not fit together")]
    Malformed,
}

impl TourProblem {
    /// Number of stops.
    pub fn len(&self) -> usize {
        self.from_start.len()
    }

    /// Whether there are no stops.
    pub fn is_empty(&self) -> bool {
        self.from_start.is_empty()
    }

    /// Cost of an order.
    pub fn cost(&self, order: &[usize]) -> f64 {
        let (Some(&first), Some(&last)) = (order.first(), order.last()) else { return 0.0 };
        let between: f64 = order.windows(2).map(|pair| self.between[pair[0]][pair[1]]).sum();
        self.from_start[first] + between + self.to_end[last]
    }

    /// Whether an order has the first and last stop where they belong, and meets the constraints.
    pub fn permits(&self, order: &[usize]) -> bool {
        let mut place = vec![0; order.len()];
        for (position, &stop) in order.iter().enumerate() {
            place[stop] = position;
        }
        self.first.is_none_or(|stop| place[stop] == 0)
            && self.last.is_none_or(|stop| place[stop] + 1 == order.len())
            && self.before.iter().all(|&[first, second]| place[first] < place[second])
    }

    /// For each stop, the stops that come before it. First and last stop are expressed by these too.
    pub(super) fn predecessors(&self) -> Vec<Vec<usize>> {
        let count = self.len();
        let mut predecessors = vec![Vec::new(); count];
        for &[first, second] in &self.before {
            predecessors[second].push(first);
        }
        for stop in 0..count {
            if let Some(first) = self.first.filter(|&first| first != stop) {
                predecessors[stop].push(first);
            }
            if let Some(last) = self.last.filter(|&last| last != stop) {
                predecessors[last].push(stop);
            }
        }
        predecessors
    }

    fn is_well_formed(&self) -> bool {
        let count = self.len();
        let exists = |stop: &usize| *stop < count;
        self.between.len() == count
            && self.between.iter().all(|row| row.len() == count)
            && self.to_end.len() == count
            && self.first.iter().all(exists)
            && self.last.iter().all(exists)
            && self.before.iter().flatten().all(exists)
    }
}

/// The cheapest order: exactly up to [`TourConfig::exact_max`] stops, by a heuristic above. The same problem always has the same answer.
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
    let is_exact = problem.len() <= config.exact_max.min(20);
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

/// The algorithm of Held and Karp. `n² 2ⁿ` steps and `n 2ⁿ` numbers. None if every order has an infinite cost.
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
