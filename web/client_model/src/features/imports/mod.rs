//! Maps made of point clouds that the operator uploads.

use super::Feature;
use crate::shared::Context;
use crate::{ClientCommand, ClientEffect, ClientEvent, texts};
use api::{Import, Severity, StoredUpload};
use vocab::{MapId, UploadId};

/// A file that is being uploaded.
#[derive(Clone, Debug, PartialEq)]
pub struct Upload {
    /// Its id.
    pub upload: UploadId,
    /// The file's name.
    pub file: String,
    /// The saved map whose frame the new map shall have; its own frame if `None`.
    pub frame: Option<MapId>,
    /// Share of its bytes that was sent, 0 to 1.
    pub share: f32,
}

impl Upload {
    /// Name of the map that it becomes: the file's name without its extension.
    pub fn map_name(&self) -> &str {
        match self.file.rsplit_once('.') {
            Some((name, _)) if !name.is_empty() => name,
            _ => &self.file,
        }
    }
}

/// The upload of this client, the import that the server works at, and the files that wait there.
#[derive(Clone, Debug, Default)]
pub struct Imports {
    upload: Option<Upload>,
    /// The frame for the file that the operator is choosing.
    next_frame: Option<MapId>,
    import: Import,
    stored: Vec<StoredUpload>,
}

impl Imports {
    /// The file that this client is uploading.
    pub fn upload(&self) -> Option<&Upload> {
        self.upload.as_ref()
    }

    /// The import that the server works at, of this or another client; the last one once it has ended.
    pub fn import(&self) -> &Import {
        &self.import
    }

    /// Files that wait on the server, without the one that is being imported; the oldest first.
    pub fn stored(&self) -> impl Iterator<Item = &StoredUpload> {
        let running = match self.import {
            Import::Running { upload, .. } => Some(upload),
            _ => None,
        };
        self.stored.iter().filter(move |stored| Some(stored.upload) != running)
    }

    /// Imports a file again, under the same name and in the same frame.
    fn retry(&self, upload: UploadId, cx: &mut Context<'_>) {
        let Some(stored) = self.stored.iter().find(|stored| stored.upload == upload) else { return };
        let name = stored.name.clone().unwrap_or_else(|| texts::UNNAMED_MAP.to_owned());
        cx.send(api::Command::ImportMap { upload, name, frame: stored.frame });
    }

    /// The upload ended. A complete file becomes a map.
    fn on_upload_finished(&mut self, upload: UploadId, result: &Result<(), String>, cx: &mut Context<'_>) {
        let Some(sent) = self.upload.take_if(|it| it.upload == upload) else { return };
        match result {
            Ok(()) => {
                let name = sent.map_name().to_owned();
                cx.send(api::Command::ImportMap { upload, name, frame: sent.frame });
            }
            Err(sentence) => cx.notify(Severity::Warning, texts::upload_failed(&sent.file, sentence)),
        }
    }

    fn cancel(&mut self, cx: &mut Context<'_>) {
        if let Some(sent) = self.upload.take() {
            cx.effects.push(ClientEffect::CancelUpload(sent.upload));
        } else if let Import::Running { upload, .. } = self.import {
            cx.send(api::Command::CancelImport(upload));
        }
    }
}

impl Feature for Imports {
    fn on_event(&mut self, event: &api::Event, _cx: &mut Context<'_>) {
        match event {
            api::Event::Import(import) => self.import = import.clone(),
            api::Event::Uploads(stored) => stored.clone_into(&mut self.stored),
            _ => {}
        }
    }

    fn on_client_event(&mut self, event: &ClientEvent, cx: &mut Context<'_>) {
        match event {
            ClientEvent::UploadStarted { upload, file } => {
                let frame = self.next_frame.take();
                self.upload = Some(Upload { upload: *upload, file: file.clone(), frame, share: 0.0 });
            }
            ClientEvent::UploadProgress { upload, share } => {
                if let Some(current) = self.upload.as_mut().filter(|it| it.upload == *upload) {
                    current.share = *share;
                }
            }
            ClientEvent::UploadFinished { upload, result } => {
                self.on_upload_finished(*upload, result, cx);
            }
            _ => {}
        }
    }

    fn on_command(&mut self, command: &ClientCommand, cx: &mut Context<'_>) {
        match command {
            ClientCommand::ImportMap { frame } => {
                self.next_frame = *frame;
                cx.effects.push(ClientEffect::OpenFileDialog);
            }
            ClientCommand::CancelImport => self.cancel(cx),
            ClientCommand::RetryImport(upload) => self.retry(*upload, cx),
            ClientCommand::DeleteUpload(upload) => cx.send(api::Command::DeleteUpload(*upload)),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests;
