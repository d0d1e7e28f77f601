//! Missions and schedules as a file on the operator's machine: saved, and loaded as one step of undo.

use super::{SiteEdit, SiteFeature};
use crate::shared::Context;
use crate::{ClientEffect, texts};
use api::Severity;
use site_model::{Change, EditId, PlanFile};

impl SiteFeature {
    /// Saves all missions and schedules.
    pub(super) fn save_plan_file(&self, cx: &mut Context<'_>) {
        match self.site() {
            Some(site) => cx.effects.push(ClientEffect::SavePlanFile(PlanFile::of(site))),
            None => cx.notify(Severity::Warning, texts::SITE_NOT_LOADED.to_owned()),
        }
    }

    /// A file was chosen and read, or could not be read, as a sentence says.
    pub(super) fn on_plan_file(
        &mut self,
        name: &str,
        result: &Result<PlanFile, String>,
        cx: &mut Context<'_>,
    ) {
        let loaded = result.as_ref().map_err(String::clone).and_then(|file| self.loading(name, file));
        match loaded {
            Ok(edit) => self.edit(&edit, cx),
            Err(sentence) => cx.notify(Severity::Warning, sentence),
        }
    }

    /// What a file changes of the site, or a sentence that says why it cannot be loaded.
    fn loading(&self, name: &str, file: &PlanFile) -> Result<SiteEdit, String> {
        let site = self.site().ok_or_else(|| texts::SITE_NOT_LOADED.to_owned())?;
        let edit = file
            .edit(site, EditId(uuid::Uuid::nil()))
            .map_err(|error| texts::plan_file_unusable(name, &error.to_string()))?;
        let object = |change| match change {
            Change::Put { object, .. } => Some(object),
            Change::Remove { .. } => None,
        };
        let put: Vec<_> = edit.changes.into_iter().filter_map(object).collect();
        if put.is_empty() {
            return Err(texts::plan_file_known(name));
        }
        Ok(SiteEdit { put, removed: Vec::new() })
    }
}
