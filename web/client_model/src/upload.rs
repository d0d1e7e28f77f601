//! A point cloud of this client's on its way to being a map.

use crate::{ClientEffect, Model};
use api::{Command, Import, Severity};
use vocab::{MapId, UploadId};

/// A file that is being sent.
#[derive(Clone, Debug, PartialEq)]
pub struct Upload {
    /// Which.
    pub upload: UploadId,
    /// The file's name.
    pub file: String,
    /// The saved map whose frame it is to have.
    pub frame: Option<MapId>,
    /// How much of it has been sent, 0 to 1.
    pub share: f32,
}

impl Upload {
    /// Name of the map that it becomes: the file's without what tells its format.
    pub fn map_name(&self) -> &str {
        match self.file.rsplit_once('.') {
            Some((name, _)) if !name.is_empty() => name,
            _ => &self.file,
        }
    }
}

impl Model {
    pub(crate) fn upload_begun(&mut self, upload: UploadId, file: String) {
        self.upload = Some(Upload { upload, file, frame: self.import_frame.take(), share: 0.0 });
    }

    pub(crate) fn uploading(&mut self, upload: UploadId, share: f32) {
        if let Some(under_way) = self.upload.as_mut().filter(|it| it.upload == upload) {
            under_way.share = share;
        }
    }

    /// Once it is there, it shall become a map.
    pub(crate) fn uploaded(
        &mut self,
        upload: UploadId,
        result: Result<(), String>,
        effects: &mut Vec<ClientEffect>,
    ) {
        let Some(sent) = self.upload.take_if(|it| it.upload == upload) else { return };
        match result {
            Ok(()) => {
                let name = sent.map_name().to_owned();
                self.order(Command::ImportMap { upload, name, frame: sent.frame }, effects);
            }
            Err(sentence) => {
                self.notices.add(
                    self.now,
                    Severity::Warning,
                    format!("{} was not sent: {sentence}", sent.file),
                );
            }
        }
    }

    pub(crate) fn cancel_import(&mut self, effects: &mut Vec<ClientEffect>) {
        if let Some(sent) = self.upload.take() {
            effects.push(ClientEffect::CancelUpload(sent.upload));
        } else if let Import::Running { upload, .. } = self.import {
            self.order(Command::CancelImport(upload), effects);
        }
    }
}
