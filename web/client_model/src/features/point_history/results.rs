//! Results of an inspection point, in pages from the newest to the oldest, and as they are stored.

use crate::{StoredPage, StoredResult, StoredResultDetails};
use site_model::{ActionReport, InspectionPointId, PictureComparison, RunId, Utc};

/// A result at an inspection point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointResult {
    /// Its number among all results of the robot. Later ones are greater.
    pub number: u64,
    /// When it was stored.
    pub at: Utc,
    /// Its run.
    pub run: RunId,
    /// Number of the attempt, from 1.
    pub attempt: u32,
    /// The action, such as `photo`.
    pub kind: String,
    /// What was found; none for an action whose report is of another form.
    pub report: Option<ActionReport>,
    /// How its photo differs from an earlier one; none: it was not compared, or not yet.
    pub comparison: Option<PictureComparison>,
}

impl PointResult {
    /// Number of places in which its photo differs from the one that it was compared with.
    pub fn changes(&self) -> usize {
        self.comparison.as_ref().map_or(0, |comparison| comparison.changes().len())
    }

    /// Whether it is a photo.
    pub(super) fn has_photo(&self) -> bool {
        let mut files = self.report.iter().flat_map(|report| &report.files);
        self.kind == "photo" && files.any(|file| file.media_type.starts_with("image/"))
    }

    fn of(stored: &StoredResult) -> Self {
        Self {
            number: stored.number,
            at: stored.at,
            run: stored.run,
            attempt: stored.attempt,
            kind: stored.kind.clone(),
            report: stored.report(),
            comparison: stored.comparison.clone(),
        }
    }
}

/// The results that were fetched, the oldest first.
#[derive(Clone, Debug, Default)]
pub(super) struct PointResults {
    items: Vec<PointResult>,
    /// Where older ones begin, if there are any.
    older: Option<String>,
    /// Whether the newest page was fetched.
    is_begun: bool,
    /// Where the page begins that is on its way: none for the newest.
    awaited: Option<Option<String>>,
    revision: u64,
}

impl PointResults {
    pub(super) fn items(&self) -> &[PointResult] {
        &self.items
    }

    /// Grows with every change of the results.
    pub(super) fn revision(&self) -> u64 {
        self.revision
    }

    pub(super) fn is_whole(&self) -> bool {
        self.is_begun && self.older.is_none()
    }

    pub(super) fn is_fetching(&self) -> bool {
        self.awaited.is_some()
    }

    /// The place of a result in the list.
    pub(super) fn find(&self, number: u64) -> Option<usize> {
        self.items.binary_search_by_key(&number, |item| item.number).ok()
    }

    /// The newest page is on its way. One that was before is no longer waited for.
    pub(super) fn begin_newest(&mut self) {
        self.awaited = Some(None);
    }

    /// The next page of older results is on its way from now on. Returns where it begins; none if there is none, or another is on its way.
    pub(super) fn begin_older(&mut self) -> Option<String> {
        if self.awaited.is_some() {
            return None;
        }
        let older = self.older.clone()?;
        self.awaited = Some(Some(older.clone()));
        Some(older)
    }

    /// Whether this page is waited for.
    pub(super) fn is_awaited(&self, before: Option<&str>) -> bool {
        self.awaited.as_ref().is_some_and(|awaited| awaited.as_deref() == before)
    }

    /// The page that was waited for does not come.
    pub(super) fn give_up(&mut self) {
        self.awaited = None;
    }

    /// Adds a page. The newest page replaces what is known, except results that were stored since; if it has a result that is known, nothing is missing between
    /// them, and what is known stays.
    pub(super) fn add(&mut self, before: Option<&str>, page: &StoredPage<StoredResult>) {
        self.awaited = None;
        let mut items: Vec<PointResult> = page.items.iter().rev().map(PointResult::of).collect();
        // A comparison may have come before the page that does not have it yet.
        for item in items.iter_mut().filter(|item| item.comparison.is_none()) {
            item.comparison = self.find(item.number).and_then(|at| self.items[at].comparison.clone());
        }
        // A page without results is the last one, whatever it says.
        let next = page.next.clone().filter(|_| !page.items.is_empty());
        match (before, items.first()) {
            (None, Some(oldest)) if self.is_begun && self.find(oldest.number).is_some() => {
                for item in &items {
                    if let Some(at) = self.find(item.number) {
                        self.items[at].comparison = item.comparison.clone();
                    }
                }
                items.retain(|item| self.find(item.number).is_none());
                self.items.append(&mut items);
                self.items.sort_by_key(|item| item.number);
            }
            (None, _) => {
                let newest = items.last().map_or(0, |item| item.number);
                items.extend(std::mem::take(&mut self.items).into_iter().filter(|item| item.number > newest));
                (self.items, self.older) = (items, next);
            }
            (Some(_), _) => {
                let oldest = self.items.first().map_or(u64::MAX, |item| item.number);
                items.retain(|item| item.number < oldest);
                items.append(&mut self.items);
                (self.items, self.older) = (items, next);
            }
        }
        self.is_begun = true;
        self.revision += 1;
    }

    /// Adds a result that was stored just now, or whose photo was compared just now, if it is of this point.
    pub(super) fn add_stored(&mut self, stored: &api::StoredResult, point: InspectionPointId) {
        let Ok(details) = serde_json::from_str::<StoredResultDetails>(&stored.body) else { return };
        let comparison = stored.comparison.as_ref().and_then(|body| serde_json::from_str(body).ok());
        if let Some(at) = self.find(stored.number) {
            if self.items[at].comparison != comparison {
                self.items[at].comparison = comparison;
                self.revision += 1;
            }
            return;
        }
        let is_newer = self.items.last().is_none_or(|last| last.number < stored.number);
        if details.inspection_point != Some(point) || !is_newer {
            return;
        }
        let result = StoredResult {
            number: stored.number,
            at: Utc(stored.at.nanos()),
            kind: stored.kind.clone(),
            run: stored.run,
            step: stored.step,
            attempt: stored.attempt,
            details,
            comparison,
        };
        self.items.push(PointResult::of(&result));
        self.revision += 1;
    }
}
