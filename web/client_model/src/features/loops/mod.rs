//! Loops of the map under construction: decisions on them, adding one by hand, and the scans of a pair laid over each other.

mod comparison;
mod decisions;
mod pick;
mod scan_overlay;

pub use comparison::{CloudState, ScanComparison, correction_of, is_registered};
pub use decisions::{LoopCounts, LoopDecisions, LoopPair};
pub use pick::{LoopInitialGuess, LoopPick, LoopProposal};
pub use scan_overlay::ScanOverlay;

pub(crate) use comparison::initial_guess;

use super::Feature;
use crate::features::history::{HistoryStep, LoopEdit};
use crate::features::selection::{PointerMode, Selection};
use crate::shared::{Context, Shared, SliceChange};
use crate::{ClientCommand, ClientEvent, texts};
use api::{LoopDecision, LoopsChanged, Severity};
use comparison::KeyframeClouds;
use vocab::{KeyframeId, SessionId};

/// Parameters of loops that are added by hand.
struct LoopProposalConfig {
    /// Time after which a proposal without a decision is given up, seconds. Chosen: a comparison takes less than a second, and the queue before it some seconds. Chosen:
    /// several times both.
    max_s: f64,
}

const CONFIG: LoopProposalConfig = LoopProposalConfig { max_s: 30.0 };

/// State of all that concerns loops.
#[derive(Clone, Debug, Default)]
pub struct Loops {
    decisions: LoopDecisions,
    pick: Option<LoopPick>,
    initial_guess: LoopInitialGuess,
    proposal: Option<LoopProposal>,
    overlay: ScanOverlay,
    clouds: KeyframeClouds,
}

impl Loops {
    /// Decisions on all pairs.
    pub fn decisions(&self) -> &LoopDecisions {
        &self.decisions
    }

    /// The last decision on each pair, newest first.
    pub fn latest(&self) -> impl ExactSizeIterator<Item = &LoopDecision> + '_ {
        self.decisions.latest()
    }

    /// Grows with every change of the decisions.
    pub fn revision(&self) -> u64 {
        self.decisions.revision()
    }

    /// How far adding a loop by hand has come; `None` while nobody does.
    pub fn pick(&self) -> Option<LoopPick> {
        self.pick
    }

    /// From where the comparison of the two chosen keyframes will start.
    pub fn initial_guess(&self) -> LoopInitialGuess {
        self.initial_guess
    }

    /// The pair that was proposed here and is being compared.
    pub fn proposal(&self) -> Option<LoopProposal> {
        self.proposal
    }

    /// How the scans of the selected loop are laid over each other.
    pub fn overlay(&self) -> ScanOverlay {
        self.overlay
    }

    /// Selects something. While keyframes are chosen for a loop, a keyframe is the next of them and nothing else is selected.
    fn select(&mut self, selection: Option<Selection>, cx: &mut Context<'_>) {
        match (self.pick, selection) {
            (None, _) => cx.shared.selected.selection = selection,
            (Some(pick), Some(Selection::Keyframe(keyframe))) => {
                let next = pick.choose(keyframe);
                self.pick = Some(next);
                cx.shared.selected.selection = match next {
                    LoopPick::Second(keyframe) => Some(Selection::Keyframe(keyframe)),
                    LoopPick::First | LoopPick::Both(_) => None,
                };
            }
            (Some(_), _) => {}
        }
    }

    fn begin_pick(&mut self, begin: bool, cx: &mut Context<'_>) {
        cx.shared.selected.enter(PointerMode::Select);
        cx.shared.selected.selection = None;
        let live = cx.shared.map_views.saved().is_none();
        self.pick = (begin && live).then_some(LoopPick::First);
    }

    fn propose(&mut self, cx: &mut Context<'_>) {
        let Some(LoopPick::Both(pair)) = self.pick else { return };
        let Some(guess) = initial_guess(cx.shared.map_views.live(), pair, self.initial_guess) else {
            return;
        };
        self.pick = None;
        self.proposal = Some(LoopProposal { pair, asked: cx.now() });
        cx.send_in_control(api::Command::ProposeLoop { from: pair.from, to: pair.to, guess });
    }

    /// New decisions. A decision on the pair that was proposed here is selected, because the operator waits for it.
    fn on_decisions(&mut self, changed: &LoopsChanged, cx: &mut Context<'_>) {
        let proposed = self.proposal.map(|proposal| proposal.pair);
        let decided = changed.added.iter().map(LoopPair::of_decision).find(|pair| Some(*pair) == proposed);
        // A complete list repeats decisions from before the proposal.
        if let Some(pair) = decided.filter(|_| !changed.reset) {
            self.proposal = None;
            if self.pick.is_none() && cx.shared.map_views.saved().is_none() {
                cx.shared.selected.selection = Some(Selection::Loop(pair));
            }
        }
        self.decisions.update(changed);
    }

    /// Another session: its keyframes have nothing to do with those known here.
    fn on_session_changed(&mut self, cx: &mut Context<'_>) {
        cx.shared.history.forget_loops();
        self.proposal = None;
        self.pick = None;
        let selected = cx.shared.selected.selection;
        if matches!(selected, Some(Selection::Loop(_) | Selection::Keyframe(_)))
            && cx.shared.map_views.saved().is_none()
        {
            cx.shared.selected.selection = None;
        }
    }

    fn expire_proposal(&mut self, cx: &mut Context<'_>) {
        let Some(LoopProposal { pair, asked }) = self.proposal else { return };
        if cx.now().since(asked) > CONFIG.max_s {
            self.proposal = None;
            cx.notify(Severity::Warning, texts::proposal_expired(pair.from.0, pair.to.0));
        }
    }

    /// The scans to lay over each other; `None` if there is no pair, the overlay is off, or a saved map is viewed.
    pub(crate) fn comparison(&self, shared: &Shared) -> Option<ScanComparison> {
        if shared.map_views.saved().is_some() {
            return None;
        }
        let live = shared.map_views.live();
        let (pair, from_from_to) = match (self.pick, shared.selected.selection) {
            (Some(LoopPick::Both(pair)), _) => (pair, initial_guess(live, pair, self.initial_guess)?),
            (None, Some(Selection::Loop(pair))) => {
                (pair, comparison::overlaid(live, pair, self.overlay, self.decisions.get(pair))?)
            }
            _ => return None,
        };
        ScanComparison::of(live, pair, &from_from_to)
    }

    /// State of the scan of a keyframe; `None` while it is not wanted.
    pub(crate) fn cloud(&self, session: SessionId, keyframe: KeyframeId) -> Option<&CloudState> {
        self.clouds.get(session, keyframe)
    }
}

impl Feature for Loops {
    fn on_event(&mut self, event: &api::Event, cx: &mut Context<'_>) {
        if let api::Event::Loops(changed) = event {
            self.on_decisions(changed, cx);
        }
    }

    fn on_client_event(&mut self, event: &ClientEvent, cx: &mut Context<'_>) {
        match event {
            ClientEvent::CloudFetched { session, keyframe, result } => {
                self.clouds.on_fetched(*session, *keyframe, result.clone());
            }
            ClientEvent::Tick => self.expire_proposal(cx),
            _ => {}
        }
    }

    fn on_command(&mut self, command: &ClientCommand, cx: &mut Context<'_>) {
        match command {
            ClientCommand::Select(selection) => self.select(*selection, cx),
            ClientCommand::AcceptLoop(pair) => decide(*pair, true, cx),
            ClientCommand::RejectLoop(pair) => decide(*pair, false, cx),
            ClientCommand::UndoLoop => {
                if let Some(edit) = cx.shared.history.take_last_loop() {
                    undo_edit(edit, cx);
                }
            }
            ClientCommand::PickLoopKeyframes(begin) => self.begin_pick(*begin, cx),
            ClientCommand::SetLoopInitialGuess(guess) => self.initial_guess = *guess,
            ClientCommand::ProposeLoop => self.propose(cx),
            ClientCommand::SetScanOverlay(overlay) => self.overlay = *overlay,
            _ => {}
        }
    }

    fn on_change(&mut self, change: &SliceChange, cx: &mut Context<'_>) {
        match change {
            SliceChange::SessionChanged => self.on_session_changed(cx),
            SliceChange::MapViewed { changed: true, .. } => self.pick = None,
            SliceChange::CommandAnswered {
                command: Some(api::Command::ProposeLoop { .. }),
                accepted: false,
                ..
            } => {
                self.proposal = None;
            }
            _ => {}
        }
    }

    fn after_event(&mut self, cx: &mut Context<'_>) {
        let session = cx.shared.map_views.live().graph.session;
        let wanted = match (self.comparison(cx.shared), session) {
            (Some(ScanComparison { pair, .. }), Some(session)) => {
                vec![(session, pair.from), (session, pair.to)]
            }
            _ => Vec::new(),
        };
        self.clouds.request(&wanted, cx.effects);
    }

    fn undo(&mut self, step: HistoryStep, cx: &mut Context<'_>) -> bool {
        let HistoryStep::Loop(edit) = step else { return false };
        undo_edit(edit, cx);
        true
    }

    fn redo(&mut self, step: HistoryStep, cx: &mut Context<'_>) -> bool {
        let HistoryStep::Loop(edit) = step else { return false };
        if refuse_without_control(cx) {
            cx.shared.history.add_undone(step);
        } else {
            let edit = send_decision(edit.pair, edit.accepted, cx);
            cx.shared.history.add_redone(HistoryStep::Loop(edit));
        }
        true
    }
}

fn decide(pair: LoopPair, accepted: bool, cx: &mut Context<'_>) {
    let edit = send_decision(pair, accepted, cx);
    cx.shared.history.add(HistoryStep::Loop(edit));
}

/// Sends the opposite decision. While another client holds the control lease, the step stays in the history instead.
fn undo_edit(edit: LoopEdit, cx: &mut Context<'_>) {
    if refuse_without_control(cx) {
        cx.shared.history.add_redone(HistoryStep::Loop(edit));
    } else {
        let command = send_decision(edit.pair, !edit.accepted, cx).command;
        cx.shared.history.add_undone(HistoryStep::Loop(LoopEdit { command, ..edit }));
    }
}

/// Says so if another client holds the control lease.
fn refuse_without_control(cx: &mut Context<'_>) -> bool {
    let refused = cx.shared.is_controlled_by_other();
    if refused {
        let text = texts::loops_need_control(cx.shared.control.holder_name());
        cx.notify(Severity::Warning, text);
    }
    refused
}

fn send_decision(pair: LoopPair, accepted: bool, cx: &mut Context<'_>) -> LoopEdit {
    let LoopPair { from, to } = pair;
    let command =
        if accepted { api::Command::AcceptLoop { from, to } } else { api::Command::RejectLoop { from, to } };
    cx.take_free_control();
    let id = cx.shared.ids.command();
    cx.send_with_id(id, command);
    LoopEdit { pair, accepted, command: id }
}

#[cfg(test)]
mod tests;
