//! The largest set of things that all agree with each other.

/// Branches looked at before the best found so far is taken.
const BUDGET: usize = 20_000;

/// The largest set of at most 64 things, all pairs of which agree, among those that contain `must`. `agree[i]` has bit `j`
/// set if `i` and `j` agree. Depth-first with the count of what is left as bound; the same input gives the same set, and
/// after 20,000 branches the best one found. Source of the use: Mangelson et al., *Pairwise Consistent Measurement Set
/// Maximization*, ICRA 2018.
pub fn largest(agree: &[u64], must: usize) -> u64 {
    if must >= agree.len().min(64) {
        return 0;
    }
    let mut search = Search { agree, best: 1 << must, branches: 0 };
    search.grow(1 << must, agree[must] & !(1 << must) & valid(agree.len()));
    search.best
}

fn valid(count: usize) -> u64 {
    if count >= 64 { u64::MAX } else { (1 << count) - 1 }
}

struct Search<'a> {
    agree: &'a [u64],
    best: u64,
    branches: usize,
}

impl Search<'_> {
    fn grow(&mut self, chosen: u64, mut left: u64) {
        if chosen.count_ones() > self.best.count_ones() {
            self.best = chosen;
        }
        while left != 0 {
            self.branches += 1;
            if chosen.count_ones() + left.count_ones() <= self.best.count_ones() || self.branches > BUDGET {
                return;
            }
            // The one that agrees with most of the others first: greedy descent finds large sets early.
            let next = bits(left)
                .max_by_key(|&i| ((self.agree[i] & left).count_ones(), usize::MAX - i))
                .unwrap_or_default();
            left &= !(1 << next);
            self.grow(chosen | 1 << next, left & self.agree[next]);
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

    #[test]
    fn agrees_with_trying_every_subset() {
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
            let found = largest(&agree, 0);
            assert!(is_clique(found) && found & 1 != 0);
            assert_eq!(Some(found.count_ones()), best, "seed {seed}");
        }
    }

    #[test]
    fn sixty_four_that_all_agree_and_hard_ones_end() {
        let all: Vec<u64> = (0..64).map(|i| !(1_u64 << i)).collect();
        assert_eq!(largest(&all, 7), u64::MAX);
        // 32 pairs of which only partners disagree: 2^32 largest sets.
        let pairs: Vec<u64> = (0..64).map(|i| !(3_u64 << (i / 2 * 2))).collect();
        assert_eq!(largest(&pairs, 0).count_ones(), 32);
        assert_eq!((largest(&[], 0), largest(&[0], 0)), (0, 1));
    }
}
