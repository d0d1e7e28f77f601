//! The best correspondence of all objects at once, with the probability of each pair.

use pathfinding::kuhn_munkres::kuhn_munkres;
use pathfinding::matrix::Matrix;

/// Whole numbers for one unit of the logarithm of odds: sums of them are exact, whatever the order.
const UNITS: f64 = 1e6;
/// Rounds of belief propagation at most, and the change at which it ends. It converges from any start (Vontobel, 2013).
const MAX_ROUNDS: usize = 200;
const SMALLEST_CHANGE: f64 = 1e-9;

/// A pair of one thing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Association {
    /// Places in the two lists.
    pub pair: [usize; 2],
    /// Probability that they are one thing, given all that either may be instead.
    pub probability: f64,
}

/// The pairs with the greatest sum of logarithms of odds, each object once. `log_odds[a][b]` are those that `a` of the first list and `b` of the second are one thing, against neither of
/// them being paired; pairs with less than even odds stay apart. The rows have one length. Source: Kuhn, *The Hungarian method*, 1955 (crate `pathfinding`); cubic in the objects. The
/// probabilities are those of Williams and Lau, *Approximate evaluation of marginal association probabilities with belief propagation*, 2014: of two things of one make that have
/// both moved, each pair has about a half, whichever the assignment takes.
pub fn associate(log_odds: &[Vec<f64>]) -> Vec<Association> {
    let columns = log_odds.first().map_or(0, Vec::len);
    if columns == 0 {
        return Vec::new();
    }
    let is_wide = log_odds.len() <= columns;
    let gain = |a: usize, b: usize| (log_odds[a][b].clamp(0.0, 1e3) * UNITS) as i64;
    let rows = if is_wide { log_odds.len() } else { columns };
    let rows: Vec<Vec<i64>> = (0..rows)
        .map(|row| {
            let across = if is_wide { columns } else { log_odds.len() };
            (0..across).map(|other| if is_wide { gain(row, other) } else { gain(other, row) }).collect()
        })
        .collect();
    let Ok(weights) = Matrix::from_rows(rows) else { return Vec::new() };
    let (_, assigned) = kuhn_munkres(&weights);
    let probabilities = probabilities(log_odds);
    let pairs = assigned
        .into_iter()
        .enumerate()
        .map(|(row, other)| if is_wide { [row, other] } else { [other, row] });
    let mut found: Vec<Association> = pairs
        .filter(|[a, b]| gain(*a, *b) > 0)
        .map(|pair| Association { pair, probability: probabilities[pair[0]][pair[1]] })
        .collect();
    found.sort_by_key(|association| association.pair);
    found
}

/// Probability of each pair.
fn probabilities(log_odds: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let odds: Vec<Vec<f64>> =
        log_odds.iter().map(|row| row.iter().map(|odds| odds.clamp(-500.0, 500.0).exp()).collect()).collect();
    let columns = odds[0].len();
    // Messages from the second list to the first.
    let mut back = vec![vec![1.0_f64; columns]; odds.len()];
    for _ in 0..MAX_ROUNDS {
        let mut there = vec![vec![0.0_f64; columns]; odds.len()];
        for a in 0..odds.len() {
            let sum: f64 = (0..columns).map(|b| odds[a][b] * back[a][b]).sum();
            for b in 0..columns {
                there[a][b] = odds[a][b] / (1.0 + (sum - odds[a][b] * back[a][b]).max(0.0));
            }
        }
        let mut change = 0.0_f64;
        for b in 0..columns {
            let sum: f64 = there.iter().map(|row| row[b]).sum();
            for a in 0..odds.len() {
                let message = 1.0 / (1.0 + (sum - there[a][b]).max(0.0));
                change = change.max((message - back[a][b]).abs());
                back[a][b] = message;
            }
        }
        if change < SMALLEST_CHANGE {
            break;
        }
    }
    let of_row = |(odds, back): (&Vec<f64>, &Vec<f64>)| {
        let weights: Vec<f64> = odds.iter().zip(back).map(|(odds, back)| odds * back).collect();
        let sum = 1.0 + weights.iter().sum::<f64>();
        weights.into_iter().map(|weight| weight / sum).collect()
    };
    odds.iter().zip(&back).map(of_row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(log_odds: &[Vec<f64>]) -> Vec<[usize; 2]> {
        associate(log_odds).into_iter().map(|found| found.pair).collect()
    }

    #[test]
    fn the_sum_counts_and_not_the_best_single_pair() {
        // The greedy choice takes 5.0 and leaves the others without a partner.
        assert_eq!(pairs(&[vec![5.0, 4.5], vec![4.8, -3.0]]), [[0, 1], [1, 0]]);
    }

    #[test]
    fn what_has_no_partner_stays_alone_in_either_list() {
        assert_eq!(pairs(&[vec![-1.0, 2.0, -4.0]]), [[0, 1]]);
        assert_eq!(pairs(&[vec![-1.0], vec![3.0], vec![2.0]]), [[1, 0]]);
        assert_eq!(pairs(&[vec![-0.5]]), [[0; 2]; 0]);
        assert_eq!(pairs(&[]), [[0; 2]; 0]);
        assert_eq!(pairs(&[vec![], vec![]]), [[0; 2]; 0]);
    }

    /// Probability of each pair by all assignments.
    fn enumerated(log_odds: &[Vec<f64>]) -> Vec<Vec<f64>> {
        fn visit(
            log_odds: &[Vec<f64>],
            taken: &mut Vec<Option<usize>>,
            sum: f64,
            found: &mut Vec<(f64, Vec<Option<usize>>)>,
        ) {
            let row = taken.len();
            if row == log_odds.len() {
                found.push((sum.exp(), taken.clone()));
                return;
            }
            taken.push(None);
            visit(log_odds, taken, sum, found);
            taken.pop();
            for column in 0..log_odds[0].len() {
                if !taken.contains(&Some(column)) {
                    taken.push(Some(column));
                    visit(log_odds, taken, sum + log_odds[row][column], found);
                    taken.pop();
                }
            }
        }
        let mut all = Vec::new();
        visit(log_odds, &mut Vec::new(), 0.0, &mut all);
        let total: f64 = all.iter().map(|(weight, _)| weight).sum();
        let probability = |a: usize, b: usize| {
            all.iter().filter(|(_, taken)| taken[a] == Some(b)).map(|(weight, _)| weight).sum::<f64>() / total
        };
        (0..log_odds.len()).map(|a| (0..log_odds[0].len()).map(|b| probability(a, b)).collect()).collect()
    }

    #[test]
    fn probabilities_are_those_of_all_assignments() {
        for log_odds in [
            vec![vec![2.0, -1.0], vec![0.5, 1.0]],
            vec![vec![2.0, 2.0], vec![2.0, 2.0]],
            vec![vec![2.3, -6.0, 0.2], vec![1.0, 1.2, -2.0]],
            vec![vec![2.3], vec![2.3]],
        ] {
            for (found, exact) in
                probabilities(&log_odds).iter().flatten().zip(enumerated(&log_odds).iter().flatten())
            {
                assert!((found - exact).abs() < 0.05, "{found} {exact} {log_odds:?}");
            }
        }
    }

    #[test]
    fn two_of_one_make_are_never_certain() {
        let both = associate(&[vec![2.3, 2.3], vec![2.3, 2.3]]);
        assert_eq!(both.len(), 2);
        assert!(both.iter().all(|found| found.probability < 0.5), "{both:?}");
        let one = associate(&[vec![2.3], vec![2.3]]);
        assert!(one.len() == 1 && one[0].probability < 0.5, "{one:?}");
        let alone = associate(&[vec![2.3]]);
        assert!((alone[0].probability - 2.3_f64.exp() / (1.0 + 2.3_f64.exp())).abs() < 1e-6);
    }
}
