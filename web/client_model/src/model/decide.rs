//! Loops decided on, added and selected by a person.

use super::{Model, Selection};
use crate::history::{LoopEdit, Step};
use crate::{ClientEffect, LoopPair, LoopPick, LoopProposal};
use api::{Command, LoopsChanged, Severity};

/// A proposal that nothing was heard of for so long is given up.
const PROPOSAL_S_MAX: f64 = 30.0;

impl Model {
    /// Selects something; while keyframes are chosen for a loop, takes the next of them and nothing else.
    pub(super) fn select(&mut self, selection: Option<Selection>) {
        match (self.loop_pick, selection) {
            (None, _) => self.selection = selection,
            (Some(pick), Some(Selection::Keyframe(keyframe))) => {
                let next = pick.choose(keyframe);
                self.loop_pick = Some(next);
                self.selection = match next {
                    LoopPick::Second(keyframe) => Some(Selection::Keyframe(keyframe)),
                    LoopPick::First | LoopPick::Both(_) => None,
                };
            }
            (Some(_), _) => {}
        }
    }

    pub(super) fn pick_loop(&mut self, begin: bool) {
        (self.walk_armed, self.place_armed) = (false, false);
        self.selection = None;
        self.loop_pick = (begin && self.saved.is_none()).then_some(LoopPick::First);
    }

    pub(super) fn propose_loop(&mut self, effects: &mut Vec<ClientEffect>) {
        let Some(LoopPick::Both(pair)) = self.loop_pick else { return };
        let Some(guess) = self.guess(pair, self.loop_guess) else { return };
        self.loop_pick = None;
        self.proposed = Some(LoopProposal { pair, asked: self.now });
        self.order_in_control(Command::ProposeLoop { from: pair.from, to: pair.to, guess }, effects);
    }

    pub(super) fn decide_loop(&mut self, pair: LoopPair, accepted: bool, effects: &mut Vec<ClientEffect>) {
        let step = self.order_loop(pair, accepted, effects);
        self.history.add(Step::Loop(step));
    }

    pub(super) fn undo_loop(&mut self, effects: &mut Vec<ClientEffect>) {
        if let Some(step) = self.history.take_last_loop() {
            self.take_back(step, effects);
        }
    }

    /// Undoes a decision by the other one. What somebody else's control forbids can be undone later.
    pub(super) fn take_back(&mut self, step: LoopEdit, effects: &mut Vec<ClientEffect>) {
        if self.told_that_others_control() {
            return self.history.redone(Step::Loop(step));
        }
        let command = self.order_loop(step.pair, !step.accepted, effects).command;
        self.history.undone(Step::Loop(LoopEdit { command, ..step }));
    }

    pub(super) fn do_again(&mut self, step: LoopEdit, effects: &mut Vec<ClientEffect>) {
        if self.told_that_others_control() {
            return self.history.undone(Step::Loop(step));
        }
        let step = self.order_loop(step.pair, step.accepted, effects);
        self.history.redone(Step::Loop(step));
    }

    fn told_that_others_control(&mut self) -> bool {
        let others = self.is_controlled_by_other();
        if others {
            let text = format!("{} controls the robot. Take control to decide on loops.", self.control.name);
            self.notices.add(self.now, Severity::Warning, text);
        }
        others
    }

    fn order_loop(&mut self, pair: LoopPair, accepted: bool, effects: &mut Vec<ClientEffect>) -> LoopEdit {
        let LoopPair { from, to } = pair;
        let order =
            if accepted { Command::AcceptLoop { from, to } } else { Command::RejectLoop { from, to } };
        self.take_free_control(effects);
        let command = self.ids.command();
        self.order_as(command, order, effects);
        LoopEdit { pair, accepted, command }
    }

    /// Decisions came. The one on the pair proposed here is what the person waits for: it is shown.
    pub(super) fn learn_loops(&mut self, changed: LoopsChanged) {
        let proposed = self.proposed.map(|proposed| proposed.pair);
        let decided = changed.added.iter().map(LoopPair::decided).find(|pair| Some(*pair) == proposed);
        // A list from the start repeats what was decided before the proposal.
        if let Some(pair) = decided.filter(|_| !changed.reset) {
            self.proposed = None;
            if self.loop_pick.is_none() && self.saved.is_none() {
                self.selection = Some(Selection::Loop(pair));
            }
        }
        self.loops.change(changed);
    }

    /// Another session: its keyframes have nothing to do with those known here.
    pub(super) fn forget_loops(&mut self) {
        self.history.forget_loops();
        self.proposed = None;
        self.loop_pick = None;
        if matches!(self.selection, Some(Selection::Loop(_) | Selection::Keyframe(_))) && self.saved.is_none()
        {
            self.selection = None;
        }
    }

    pub(super) fn give_up_proposal(&mut self) {
        let Some(LoopProposal { pair, asked }) = self.proposed else { return };
        if self.now.since(asked) > PROPOSAL_S_MAX {
            self.proposed = None;
            let (from, to) = (pair.from.0, pair.to.0);
            let text = format!(
                "Nothing was heard of the comparison of keyframes {from} and {to}. Propose them again."
            );
            self.notices.add(self.now, Severity::Warning, text);
        }
    }
}
