//! The example: a site to try, which the robot's computer makes when an operator asks for it. Its progress is that of an import.

use super::Feature;
use crate::ClientCommand;
use crate::shared::Context;
use api::{Import, ImportStage};
use vocab::{MapId, UploadId};

/// How far the example is.
#[derive(Clone, Debug, Default)]
pub struct ExampleFeature {
    /// What this operator has asked for and what has not ended.
    asked: Option<UploadId>,
    /// The work that runs, of this operator or another one, with its stage and the share of it that is done.
    running: Option<(UploadId, ImportStage, f32)>,
    /// The map of the example that this operator has asked for, until it is shown.
    ready: Option<MapId>,
    /// Why it could not be made, until that is dismissed or tried again.
    failure: Option<String>,
}

impl ExampleFeature {
    /// While it is made: the stage, and the share of it that is done, 0 to 1.
    pub fn progress(&self) -> Option<(ImportStage, f32)> {
        self.running.map(|(_, stage, share)| (stage, share))
    }

    /// Whether this operator has asked for it and it is neither there nor given up.
    pub fn is_asked_for(&self) -> bool {
        self.asked.is_some()
    }

    /// Its map, once it is there and has not been shown to the operator who asked for it.
    pub fn ready(&self) -> Option<MapId> {
        self.ready
    }

    /// Why it could not be made.
    pub fn failure(&self) -> Option<&str> {
        self.failure.as_deref()
    }

    fn on_import(&mut self, import: &Import) {
        match import {
            // Only the making of an example has these two stages.
            Import::Running { upload, stage, share, .. }
                if matches!(stage, ImportStage::Walking | ImportStage::MakingTopomap)
                    || self.asked == Some(*upload)
                    || self.running.is_some_and(|(running, ..)| running == *upload) =>
            {
                self.running = Some((*upload, *stage, *share));
            }
            Import::None | Import::Running { .. } => self.running = None,
            Import::Done { upload, map } => {
                self.running = None;
                if self.asked.take_if(|asked| asked == upload).is_some() {
                    self.ready = Some(*map);
                }
            }
            Import::Failed { upload, reason, .. } => {
                self.running = None;
                if self.asked.take_if(|asked| asked == upload).is_some() {
                    self.failure = Some(reason.clone());
                }
            }
        }
    }
}

impl Feature for ExampleFeature {
    fn on_event(&mut self, event: &api::Event, _cx: &mut Context<'_>) {
        if let api::Event::Import(import) = event {
            self.on_import(import);
        }
    }

    fn on_command(&mut self, command: &ClientCommand, cx: &mut Context<'_>) {
        match command {
            ClientCommand::MakeExample { time_zone } => {
                let upload = UploadId(cx.shared.ids.command().0);
                (self.asked, self.failure) = (Some(upload), None);
                cx.send(api::Command::MakeExample { upload, time_zone: time_zone.clone() });
            }
            ClientCommand::CancelExample => {
                if let Some((upload, ..)) = self.running {
                    // That it was cancelled is no failure to tell.
                    self.asked = None;
                    cx.send(api::Command::CancelImport(upload));
                }
            }
            ClientCommand::DismissExample => (self.ready, self.failure) = (None, None),
            _ => {}
        }
    }

    fn on_change(&mut self, change: &crate::shared::SliceChange, _cx: &mut Context<'_>) {
        if let crate::shared::SliceChange::CommandAnswered {
            command: Some(api::Command::MakeExample { upload, .. }),
            accepted: false,
            ..
        } = change
        {
            // The reason is a notice.
            self.asked.take_if(|asked| asked == upload);
        }
    }
}

#[cfg(test)]
mod tests;
