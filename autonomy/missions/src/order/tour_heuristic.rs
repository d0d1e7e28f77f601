//! Good orders of many stops: several starts, each improved by moving segments (Or-opt) and by reversing them (2-opt).

use super::{TourConfig, TourProblem};

/// The best order that was found. None if all that were found have an infinite cost. Each improvement takes quadratic time.
pub(super) fn find_order(
    problem: &TourProblem,
    predecessors: &[Vec<usize>],
    config: &TourConfig,
) -> Option<Vec<usize>> {
    let walkable = finite(problem, config.not_walkable_cost);
    let starts = starts(&walkable, predecessors, config.max_starts.max(1));
    let improved = starts.into_iter().map(|order| improve(&walkable, order, config));
    let best = improved.min_by(|a, b| walkable.cost(a).total_cmp(&walkable.cost(b)))?;
    problem.cost(&best).is_finite().then_some(best)
}

fn finite(problem: &TourProblem, greatest: f64) -> TourProblem {
    let finite = |costs: &Vec<f64>| costs.iter().map(|cost| cost.min(greatest)).collect::<Vec<_>>();
    TourProblem {
        from_start: finite(&problem.from_start),
        between: problem.between.iter().map(finite).collect(),
        to_end: finite(&problem.to_end),
        ..problem.clone()
    }
}

/// Orders to begin with: as numbered, and by the nearest neighbour from several first stops, the nearest to the start first.
fn starts(problem: &TourProblem, predecessors: &[Vec<usize>], count: usize) -> Vec<Vec<usize>> {
    let as_numbered = build(predecessors, |_, free| free.iter().copied().min());
    let mut firsts: Vec<usize> = (0..problem.len()).filter(|&stop| predecessors[stop].is_empty()).collect();
    firsts.sort_by(|&a, &b| problem.from_start[a].total_cmp(&problem.from_start[b]));
    let nearest = firsts.into_iter().map(|first| {
        build(predecessors, |last, free| {
            let Some(last) = last else { return Some(first) };
            let cost = |stop: usize| problem.between[last][stop];
            free.iter().copied().min_by(|&a, &b| cost(a).total_cmp(&cost(b)))
        })
    });
    std::iter::once(as_numbered).chain(nearest).take(count).collect()
}

/// Puts one stop after the other, chosen from those whose predecessors are placed.
fn build(
    predecessors: &[Vec<usize>],
    choose: impl Fn(Option<usize>, &[usize]) -> Option<usize>,
) -> Vec<usize> {
    let mut order: Vec<usize> = Vec::new();
    let mut is_placed = vec![false; predecessors.len()];
    while order.len() < predecessors.len() {
        let is_free =
            |&stop: &usize| !is_placed[stop] && predecessors[stop].iter().all(|&other| is_placed[other]);
        let free: Vec<usize> = (0..predecessors.len()).filter(is_free).collect();
        let Some(stop) = choose(order.last().copied(), &free) else { break };
        is_placed[stop] = true;
        order.push(stop);
    }
    order
}

/// Improves an order until no segment can be moved or reversed with gain.
fn improve(problem: &TourProblem, mut order: Vec<usize>, config: &TourConfig) -> Vec<usize> {
    for _ in 0..config.max_improvements {
        let Some(better) = find_improvement(problem, &order, config) else { break };
        order = better;
    }
    order
}

/// The move with the greatest gain. Each move is judged in constant time.
fn find_improvement(problem: &TourProblem, order: &[usize], config: &TourConfig) -> Option<Vec<usize>> {
    let walk = Walk::new(problem, order);
    let count = order.len();
    let mut best = (-config.min_improvement_ratio * (1.0 + problem.cost(order)), None);
    let mut consider = |change: f64, begin: usize, end: usize, to: usize, is_reversed: bool| {
        if change < best.0 {
            let changed = moved(order, begin, end, to, is_reversed);
            if problem.permits(&changed) {
                best = (change, Some(changed));
            }
        }
    };
    for begin in 0..count {
        for end in begin + 1..=count {
            if end - begin > 1 {
                consider(walk.reversal(begin, end), begin, end, begin, true);
            }
            if end - begin > config.max_segment_stops {
                continue;
            }
            for to in (0..begin).chain(end + 1..=count) {
                for is_reversed in [false, true] {
                    consider(walk.relocation(begin, end, to, is_reversed), begin, end, to, is_reversed);
                }
            }
        }
    }
    best.1
}

/// The order with the segment from `begin` to before `end` put before position `to`, which is not inside it.
fn moved(order: &[usize], begin: usize, end: usize, to: usize, is_reversed: bool) -> Vec<usize> {
    let mut segment = order[begin..end].to_vec();
    if is_reversed {
        segment.reverse();
    }
    let outside = |range: std::ops::Range<usize>| {
        range.filter(|position| !(begin..end).contains(position)).map(|position| order[position])
    };
    outside(0..to).chain(segment).chain(outside(to..order.len())).collect()
}

/// An order with sums of its costs (`docs/maths/tour.md`, equation 3), so that the cost of any segment, forwards and backwards, takes constant
/// time.
struct Walk<'a> {
    problem: &'a TourProblem,
    order: &'a [usize],
    forwards: Vec<f64>,
    backwards: Vec<f64>,
}

impl<'a> Walk<'a> {
    fn new(problem: &'a TourProblem, order: &'a [usize]) -> Self {
        let sums = |cost: &dyn Fn(usize, usize) -> f64| {
            let mut sum = 0.0;
            let steps = order.windows(2).map(|pair| {
                sum += cost(pair[0], pair[1]);
                sum
            });
            std::iter::once(0.0).chain(steps.collect::<Vec<_>>()).collect()
        };
        let forwards = sums(&|a, b| problem.between[a][b]);
        let backwards = sums(&|a, b| problem.between[b][a]);
        Self { problem, order, forwards, backwards }
    }

    /// Cost of the step between two neighbours; none stands for the start and the end.
    fn step(&self, from: Option<usize>, to: Option<usize>) -> f64 {
        match (from, to) {
            (Some(from), Some(to)) => self.problem.between[from][to],
            (None, Some(to)) => self.problem.from_start[to],
            (Some(from), None) => self.problem.to_end[from],
            (None, None) => 0.0,
        }
    }

    /// The stop before a position; none before the first.
    fn before(&self, position: usize) -> Option<usize> {
        position.checked_sub(1).map(|before| self.order[before])
    }

    /// The stop at a position; none after the last.
    fn at(&self, position: usize) -> Option<usize> {
        self.order.get(position).copied()
    }

    /// What walking a segment backwards instead of forwards adds, without the steps at its ends (`docs/maths/tour.md`, equation 4).
    fn turning(&self, begin: usize, end: usize) -> f64 {
        (self.backwards[end - 1] - self.backwards[begin]) - (self.forwards[end - 1] - self.forwards[begin])
    }

    /// Change of the cost by reversing a segment.
    fn reversal(&self, begin: usize, end: usize) -> f64 {
        let (before, after) = (self.before(begin), self.at(end));
        let (first, last) = (self.at(begin), self.at(end - 1));
        self.step(before, last) + self.step(first, after) + self.turning(begin, end)
            - self.step(before, first)
            - self.step(last, after)
    }

    /// Change of the cost by moving a segment before position `to`.
    fn relocation(&self, begin: usize, end: usize, to: usize, is_reversed: bool) -> f64 {
        let (mut first, mut last) = (self.at(begin), self.at(end - 1));
        let (before, after) = (self.before(begin), self.at(end));
        let taken_out = self.step(before, after) - self.step(before, first) - self.step(last, after);
        let (left, right) = (self.before(to), self.at(to));
        if is_reversed {
            std::mem::swap(&mut first, &mut last);
        }
        let turning = if is_reversed { self.turning(begin, end) } else { 0.0 };
        taken_out + self.step(left, first) + self.step(last, right) - self.step(left, right) + turning
    }
}
