//! Where something passed during a visit, such as a person.

use crate::ChangesConfig;
use crate::side::Side;
use points::hash::CellKey;
use std::cell::RefCell;
use std::collections::BTreeMap;

/// Answers whether what a visit saw at a place was there for a part of it only. What is known of one point of a small cell holds for all of it, and is looked up once.
pub(crate) struct Passing<'a> {
    visit: &'a Side,
    config: &'a ChangesConfig,
    known: RefCell<BTreeMap<CellKey, bool>>,
}

impl<'a> Passing<'a> {
    pub(crate) fn new(visit: &'a Side, config: &'a ChangesConfig) -> Self {
        Self { visit, config, known: RefCell::default() }
    }

    /// Whether what was at a place passed. Linear in the views for a new cell.
    pub(crate) fn at(&self, place: &[f32; 3]) -> bool {
        let cell = CellKey::of_point(place, 1.0 / self.config.candidate_cell_m as f32);
        *self.known.borrow_mut().entry(cell).or_insert_with(|| {
            self.visit.was_passing(&[self.visit.probed(place, self.config)], self.config) == [true]
        })
    }
}
