//! Where something passed during a visit, such as a person.

use crate::ChangesConfig;
use crate::join::InTurn;
use crate::side::Side;
use points::hash::{CellKey, CellTable};

/// Answers whether what a visit saw at places was there for a part of it only. What is known of one point of a small cell holds for all of it, and is looked up once.
pub(crate) struct Passing<'a> {
    visit: &'a Side,
    config: &'a ChangesConfig,
    /// Each cell with its place in `answers`.
    cells: CellTable,
    answers: Vec<bool>,
}

impl<'a> Passing<'a> {
    pub(crate) fn new(visit: &'a Side, config: &'a ChangesConfig) -> Self {
        Self { visit, config, cells: CellTable::default(), answers: Vec::new() }
    }

    /// Whether what was at each of these places passed. Linear in the views for each new cell.
    pub(crate) fn at(&mut self, places: &[[f32; 3]]) -> impl Iterator<Item = bool> {
        let cells_per_m = 1.0 / self.config.candidate_cell_m as f32;
        let mut new = Vec::new();
        let mut answers_of = Vec::with_capacity(places.len());
        for place in places {
            let next = (self.answers.len() + new.len()) as u32;
            let (answer, is_new) = self.cells.get_or_insert(CellKey::of_point(place, cells_per_m), next);
            if is_new {
                new.push(*place);
            }
            answers_of.push(answer as usize);
        }
        self.answers.extend(self.visit.was_passing(&new, &InTurn, self.config));
        answers_of.into_iter().map(|answer| self.answers[answer])
    }
}
