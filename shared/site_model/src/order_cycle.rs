//! Order constraints of a mission that contradict each other.

use crate::TaskId;
use std::collections::BTreeSet;

/// The tasks of a circle of order constraints, each of which has to be done before the next one, and the last before the first. None if some order of the tasks meets all
/// constraints. Quadratic in the constraints. The same constraints in the same order give the same circle.
pub fn find_order_cycle(constraints: &[[TaskId; 2]]) -> Option<Vec<TaskId>> {
    // Constraints whose first task waits for no other are met by doing it first.
    let mut left = constraints.to_vec();
    loop {
        let waiting: BTreeSet<_> = left.iter().map(|[_, second]| *second).collect();
        let before = left.len();
        left.retain(|[first, _]| waiting.contains(first));
        if left.len() == before {
            break;
        }
    }
    // Every first task that is left waits for another one, so the way back from task to task meets itself.
    let mut walked = vec![left.first()?[0]];
    loop {
        let last = *walked.last()?;
        let [before, _] = left.iter().find(|[_, second]| *second == last)?;
        if let Some(start) = walked.iter().position(|task| task == before) {
            let mut circle = walked.split_off(start);
            circle.reverse();
            return Some(circle);
        }
        walked.push(*before);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use uuid::Uuid;

    fn cycle(constraints: &[[u128; 2]]) -> Option<Vec<u128>> {
        let of = |pair: &[u128; 2]| pair.map(|task| TaskId(Uuid::from_u128(task)));
        let constraints: Vec<_> = constraints.iter().map(of).collect();
        find_order_cycle(&constraints).map(|tasks| tasks.iter().map(|task| task.0.as_u128()).collect())
    }

    #[test]
    fn a_circle_is_named_without_the_tasks_that_lead_to_it_or_away_from_it() {
        assert_eq!(cycle(&[]), None);
        assert_eq!(cycle(&[[1, 2], [2, 3], [1, 3], [4, 3]]), None);
        assert_eq!(cycle(&[[7, 7]]), Some(vec![7]));
        let found = cycle(&[[9, 1], [1, 2], [2, 3], [3, 1], [3, 8], [8, 5]]).unwrap();
        let at = found.iter().position(|task| *task == 1).unwrap();
        let turned: Vec<u128> = (0..found.len()).map(|step| found[(at + step) % found.len()]).collect();
        assert_eq!(turned, [1, 2, 3]);
    }
}
