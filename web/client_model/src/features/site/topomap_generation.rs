//! The making of the topological map from a saved map: the robot does it, and its edit is one that this operator can undo.

use api::TopomapGeneration;
use site_model::EditId;

/// What is known of it.
#[derive(Clone, Debug, Default)]
pub(super) struct TopomapProgress {
    state: TopomapGeneration,
    /// Whether it ended while this client was watching, and nobody has dismissed the result.
    is_result_shown: bool,
    /// The edits that this operator has asked for and that have not come.
    awaited: Vec<EditId>,
}

impl TopomapProgress {
    /// What the operator shall see.
    pub(super) fn shown(&self) -> &TopomapGeneration {
        match &self.state {
            TopomapGeneration::Running { .. } => &self.state,
            _ if self.is_result_shown => &self.state,
            _ => &TopomapGeneration::None,
        }
    }

    pub(super) fn on_state(&mut self, state: &TopomapGeneration) {
        let was_running = matches!(self.state, TopomapGeneration::Running { .. });
        let is_running = matches!(state, TopomapGeneration::Running { .. });
        if was_running || is_running {
            self.is_result_shown = !is_running;
        }
        if let TopomapGeneration::Failed { .. } = state {
            self.awaited.clear();
        }
        state.clone_into(&mut self.state);
    }

    pub(super) fn dismiss(&mut self) {
        self.is_result_shown = false;
    }

    /// The operator has asked for an edit of this id.
    pub(super) fn wait_for(&mut self, edit: EditId) {
        self.awaited.push(edit);
    }

    /// Whether an edit that has come is the operator's. It is then no longer waited for.
    pub(super) fn remove_awaited(&mut self, edit: EditId) -> bool {
        let before = self.awaited.len();
        self.awaited.retain(|awaited| *awaited != edit);
        self.awaited.len() < before
    }
}
