//! The results of a run by their attempts. Results are stored in the order in which they came, which is not that of the tasks where one was tried later or done
//! again. Memory holds a page of them, and a number for each.

use crate::runs::{CoreQueries, result_page};
use api::StoredResult;
use site_model::RunId;
use std::io;

/// The results of a run.
pub(super) struct ResultsByAttempt<'c> {
    core: &'c dyn CoreQueries,
    run: RunId,
    /// Step, attempt and number of each, in this order.
    index: Vec<(u32, u32, u64)>,
    /// Results in the order of their numbers.
    page: Vec<StoredResult>,
}

impl<'c> ResultsByAttempt<'c> {
    /// Reads which results there are.
    ///
    /// # Errors
    /// When the core fails.
    pub(super) fn read(core: &'c dyn CoreQueries, run: RunId) -> io::Result<Self> {
        let mut results = Self { core, run, index: Vec::new(), page: Vec::new() };
        let mut after = None;
        loop {
            let page = result_page(core, run, after)?;
            let Some(last) = page.last() else { break };
            after = Some(last.number);
            results.index.extend(page.iter().map(|result| (result.step, result.attempt, result.number)));
            // The first page is the first that is asked for, and mostly the only one.
            if results.page.is_empty() {
                results.page = page;
            }
        }
        results.index.sort_unstable();
        Ok(results)
    }

    /// Hands the results of an attempt to `take`, in the order in which they were stored.
    ///
    /// # Errors
    /// When the core or `take` fails.
    pub(super) fn for_each_of(
        &mut self,
        step: u32,
        attempt: u32,
        mut take: impl FnMut(&StoredResult) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut at = self.index.partition_point(|(s, a, _)| (*s, *a) < (step, attempt));
        while let Some((_, _, number)) = self.index.get(at).filter(|(s, a, _)| (*s, *a) == (step, attempt)) {
            let number = *number;
            if let Some(result) = self.fetch(number)? {
                take(result)?;
            }
            at += 1;
        }
        Ok(())
    }

    /// The result of this number, with those after it where it is not in memory.
    fn fetch(&mut self, number: u64) -> io::Result<Option<&StoredResult>> {
        if self.page.binary_search_by_key(&number, |result| result.number).is_err() {
            self.page = result_page(self.core, self.run, number.checked_sub(1))?;
        }
        let found = self.page.binary_search_by_key(&number, |result| result.number);
        Ok(found.ok().and_then(|at| self.page.get(at)))
    }
}
