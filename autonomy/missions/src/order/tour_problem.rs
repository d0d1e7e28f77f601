//! Stops to be put in order, what an order costs, and why there may be none.

/// Parameters of [`solve`](super::solve).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TourConfig {
    /// Greatest number of stops that is solved exactly. Time and memory double with each more; 12 take milliseconds. Chosen: one more takes twice the time and memory
    /// (docs/maths/tour.md: 590,000 steps and 400 kB).
    pub max_exact: usize,
    /// Greatest number of starts of the heuristic. More starts find better orders in proportion to the time. Source: docs/maths/tour.md, section 3: the order of the list
    /// and eleven first stops.
    pub max_starts: usize,
    /// Greatest number of improvements after each start: a bound on the time, never reached in tests with 60 stops. Chosen far above that.
    pub max_improvements: usize,
    /// Improvements smaller than this share of the cost are rounding. Chosen: above the rounding of a sum of a hundred costs, and below a millisecond of an hour.
    pub min_improvement_ratio: f64,
    /// Longest segment that is moved as a whole, stops; as usual for Or-opt. Source: Or, 1976 (docs/maths/tour.md).
    pub max_segment_stops: usize,
    /// Cost that stands for infinite ones, so that differences can be computed. Any finite cost of a mission is smaller. Chosen: 30,000 years in seconds.
    pub not_walkable_cost: f64,
}

impl Default for TourConfig {
    fn default() -> Self {
        Self {
            max_exact: 12,
            max_starts: 12,
            max_improvements: 2_000,
            min_improvement_ratio: 1e-9,
            max_segment_stops: 3,
            not_walkable_cost: 1e12,
        }
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

    /// Cost of an order (`docs/maths/tour.md`, equation 1).
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

    pub(super) fn is_well_formed(&self) -> bool {
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
