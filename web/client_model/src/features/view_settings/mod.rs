//! How things look: settings that are kept from visit to visit and can be undone; the screen; the camera.

mod settings;

pub use settings::{Bookmark, CameraPose, ColourBy, Screen, Theme, ViewSettings};

use super::Feature;
use crate::features::history::{EditResult, HistoryStep, ValueHistory};
use crate::shared::Context;
use crate::{CameraMove, ClientCommand, ClientEffect};

/// The view settings with their undo history, and the screen that is on.
#[derive(Clone, Debug)]
pub struct ViewFeature {
    settings: ValueHistory<ViewSettings>,
    screen: Option<Screen>,
}

impl Default for ViewFeature {
    fn default() -> Self {
        Self::new(ViewSettings::default())
    }
}

impl ViewFeature {
    pub(crate) fn new(settings: ViewSettings) -> Self {
        Self { settings: ValueHistory::new(settings), screen: None }
    }

    /// How things look.
    pub fn settings(&self) -> &ViewSettings {
        self.settings.get()
    }

    /// The screen that the operator chose last; `None` before the first choice.
    pub fn screen(&self) -> Option<Screen> {
        self.screen
    }

    fn edit(&mut self, settings: ViewSettings, cx: &mut Context<'_>) {
        let result = self.settings.set(cx.now(), settings);
        if result == EditResult::NewStep {
            cx.shared.history.add(HistoryStep::View);
        }
        if result != EditResult::Unchanged {
            self.save(cx);
        }
    }

    fn save(&self, cx: &mut Context<'_>) {
        cx.effects.push(ClientEffect::SaveSettings(self.settings.get().clone()));
    }

    fn move_camera(&mut self, to: &CameraMove, cx: &mut Context<'_>) {
        // Following the robot would pull the camera back at once.
        if !matches!(to, CameraMove::Robot | CameraMove::SaveBookmark(_)) && self.settings().follow {
            let settings = ViewSettings { follow: false, ..self.settings().clone() };
            self.edit(settings, cx);
        }
        cx.effects.push(ClientEffect::MoveCamera(to.clone()));
    }
}

impl Feature for ViewFeature {
    fn on_command(&mut self, command: &ClientCommand, cx: &mut Context<'_>) {
        match command {
            ClientCommand::ShowScreen(screen) => self.screen = Some(*screen),
            ClientCommand::EditView(settings) => self.edit(settings.clone(), cx),
            ClientCommand::MoveCamera(to) => self.move_camera(to, cx),
            _ => {}
        }
    }

    fn undo(&mut self, step: HistoryStep, cx: &mut Context<'_>) -> bool {
        let undone = step == HistoryStep::View && self.settings.undo();
        if undone {
            self.save(cx);
            cx.shared.history.add_undone(step);
        }
        undone
    }

    fn redo(&mut self, step: HistoryStep, cx: &mut Context<'_>) -> bool {
        let redone = step == HistoryStep::View && self.settings.redo();
        if redone {
            self.save(cx);
            cx.shared.history.add_redone(step);
        }
        redone
    }
}

#[cfg(test)]
mod tests;
