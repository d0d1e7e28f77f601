//! How independent halves of a comparison are computed. The crate itself knows no threads.

/// Does two independent pieces of work.
pub trait Join: Sync {
    /// Does both, in any order or at the same time, and returns both results.
    fn join<A: Send, B: Send>(
        &self,
        first: impl FnOnce() -> A + Send,
        second: impl FnOnce() -> B + Send,
    ) -> (A, B);
}

/// One after the other.
#[derive(Clone, Copy, Debug, Default)]
pub struct InTurn;

impl Join for InTurn {
    fn join<A: Send, B: Send>(
        &self,
        first: impl FnOnce() -> A + Send,
        second: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        (first(), second())
    }
}

/// The answer for each item: those for every second one and for the others are independent.
pub(crate) fn alternately<T: Sync, A: Send>(
    items: &[T],
    join: &impl Join,
    answer: impl Fn(&T) -> A + Sync,
) -> Vec<A> {
    let from = |first: usize| items.iter().skip(first).step_by(2).map(&answer).collect::<Vec<A>>();
    let (even, odd) = join.join(|| from(0), || from(1));
    let mut odd = odd.into_iter();
    even.into_iter().flat_map(|answer| std::iter::once(answer).chain(odd.next())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_in_the_order_of_the_items() {
        for count in 0..6 {
            let items: Vec<usize> = (0..count).collect();
            assert_eq!(alternately(&items, &InTurn, |item| *item), items);
        }
    }
}
