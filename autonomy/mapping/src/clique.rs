//! Maximum clique of a small graph given as bit sets.

/// The largest clique that contains the node `required`, in a graph of at most 64 nodes. `agree[i]` has bit `j` set if `i` and `j` are
/// adjacent. Depth-first search with the number of remaining nodes as bound. The same input gives the same clique. The result is exact up
/// to `max_branches` branches, and the best one found beyond. Source of the use: Mangelson et al., *Pairwise Consistent Measurement Set
/// Maximization*, ICRA 2018.
pub fn largest_clique(agree: &[u64], required: usize, max_branches: usize) -> u64 {
    if required >= agree.len().min(64) {
        return 0;
    }
    let mut search = Search { agree, best: 1 << required, branches: 0, max_branches };
    search.extend(1 << required, agree[required] & !(1 << required) & valid(agree.len()));
    search.best
}

fn valid(count: usize) -> u64 {
    if count >= 64 { u64::MAX } else { (1 << count) - 1 }
}

struct Search<'a> {
    agree: &'a [u64],
    best: u64,
    branches: usize,
    max_branches: usize,
}

impl Search<'_> {
    fn extend(&mut self, chosen: u64, mut left: u64) {
        if chosen.count_ones() > self.best.count_ones() {
            self.best = chosen;
        }
        while left != 0 {
            self.branches += 1;
            if chosen.count_ones() + left.count_ones() <= self.best.count_ones()
                || self.branches > self.max_branches
            {
                return;
            }
            // The node with most neighbours among the remaining ones first: this greedy order finds large cliques early.
            let next = bits(left)
                .max_by_key(|&i| ((self.agree[i] & left).count_ones(), usize::MAX - i))
                .unwrap_or_default();
            left &= !(1 << next);
            self.extend(chosen | 1 << next, left & self.agree[next]);
        }
    }
}

/// Positions of set bits, lowest first.
pub fn bits(mut set: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (set != 0).then(|| {
            let bit = set.trailing_zeros() as usize;
            set &= set - 1;
            bit
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::RngTree;

    const MAX_BRANCHES: usize = 20_000;

    #[test]
    fn agrees_with_an_exhaustive_search() {
        for seed in 0..40 {
            let mut rng = RngTree::new(seed).child("clique").rng();
            let count = 11;
            let mut agree = vec![0_u64; count];
            for i in 0..count {
                for j in 0..i {
                    if rng.uniform() < 0.55 {
                        agree[i] |= 1 << j;
                        agree[j] |= 1 << i;
                    }
                }
            }
            let is_clique = |set: u64| bits(set).all(|i| set & !(1 << i) & !agree[i] == 0);
            let best = (0..1_u64 << count).filter(|s| s & 1 != 0 && is_clique(*s)).map(u64::count_ones).max();
            let found = largest_clique(&agree, 0, MAX_BRANCHES);
            assert!(is_clique(found) && found & 1 != 0);
            assert_eq!(Some(found.count_ones()), best, "seed {seed}");
        }
    }

    #[test]
    fn a_full_graph_of_64_nodes_and_a_hard_one_are_searched_in_bounded_time() {
        let all: Vec<u64> = (0..64).map(|i| !(1_u64 << i)).collect();
        assert_eq!(largest_clique(&all, 7, MAX_BRANCHES), u64::MAX);
        // 32 pairs of which only partners are not adjacent: 2^32 maximum cliques.
        let pairs: Vec<u64> = (0..64).map(|i| !(3_u64 << (i / 2 * 2))).collect();
        assert_eq!(largest_clique(&pairs, 0, MAX_BRANCHES).count_ones(), 32);
        assert_eq!((largest_clique(&[], 0, MAX_BRANCHES), largest_clique(&[0], 0, MAX_BRANCHES)), (0, 1));
    }
}
