//! Changes that are the new normal: a new version of the map shows them. It is made by the [`MapImporter`](ports::MapImporter) in another process, on the import thread. The store then
//! adopts it, the ledger notes in one edit what is normal now, and a robot that is localised in the old version and not on a run is localised in the new one.

use crate::imports::{ImportWorker, NormalRequest, store_reason};
use crate::texts;
use api::{ImportStage, MapSummary};
use messages::{Command, CommandKind, Principal};
use site_model::{Edit, EditId, Object, ReviewState, RunId, SceneChange, SceneChangeId, Site};
use std::cmp::Reverse;
use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::PathBuf;
use uuid::Uuid;
use vocab::{ClientId, CommandId, MapId, UploadId};

/// Parameters of new versions.
struct NewNormalConfig {
    /// Other changes of the map that the new version takes over, those that were seen last. Chosen: one edit with so many objects is written in tens of milliseconds.
    max_taken_over: usize,
}

const CONFIG: NewNormalConfig = NewNormalConfig { max_taken_over: 1_000 };

/// Changes of one map, and the runs that found them.
#[derive(Debug)]
struct AcceptedChanges {
    map: MapId,
    changes: Vec<SceneChange>,
    runs: BTreeSet<RunId>,
}

impl ImportWorker {
    /// Makes the new version. Map and site are as before if it fails.
    ///
    /// # Errors
    /// Why it was not made, a sentence for people.
    pub(crate) fn make_normal(
        &self,
        upload: UploadId,
        by: &Principal,
        request: NormalRequest<'_>,
        progress: &mut dyn FnMut(ImportStage, f32) -> ControlFlow<()>,
    ) -> Result<MapSummary, String> {
        if progress(ImportStage::Reading, 0.0).is_break() {
            return Err(texts::IMPORT_CANCELLED.to_owned());
        }
        let accepted = self.accepted_changes(by, request.changes)?;
        let map = accepted.map;
        self.usage.begin_import(upload, vec![map]);
        let folder = self.store.dir().map(map);
        if !folder.exists() {
            return Err(texts::MAP_OF_CHANGES_MISSING.to_owned());
        }
        if !self.store.has_space_for_copy(map).map_err(|error| store_reason(&error))? {
            return Err(texts::NO_SPACE_FOR_COPY.to_owned());
        }
        let after: Vec<PathBuf> =
            accepted.runs.iter().map(|run| self.store.dir().clouds_of_run(*run)).collect();
        if after.iter().any(|clouds| !clouds.exists()) {
            return Err(texts::CLOUDS_OF_RUN_MISSING.to_owned());
        }
        self.importer.make_normal(&folder, &after, &accepted.changes, request.name, request.out, progress)?;
        let version = self.adopt(upload, request.out)?;
        let edit = EditId(upload.0);
        let ids: BTreeSet<SceneChangeId> = accepted.changes.iter().map(|change| change.id).collect();
        let to = version.id;
        self.change_site(by, move |site| edit_of(site, edit, map, to, &ids))?;
        self.localise_in_version(upload, by, map, to);
        Ok(version)
    }

    /// Looks the changes up in the site.
    fn accepted_changes(&self, by: &Principal, ids: &[SceneChangeId]) -> Result<AcceptedChanges, String> {
        let ids: BTreeSet<SceneChangeId> = ids.iter().copied().collect();
        let (sender, found) = crossbeam_channel::bounded(1);
        self.change_site(by, move |site| {
            let found = site.scene_changes().filter(|change| ids.contains(&change.id));
            let _ = sender.send(found.cloned().collect::<Vec<_>>());
            Edit { id: EditId(Uuid::nil()), changes: Vec::new() }
        })?;
        of_one_map(found.try_recv().unwrap_or_default()).map_err(str::to_owned)
    }

    /// Lets a robot go on in the new version, unless somebody else controls it. Its pose is the same there, because keyframes keep theirs. Control that nobody had is free again
    /// afterwards.
    fn localise_in_version(&self, upload: UploadId, by: &Principal, from: MapId, to: MapId) {
        if !self.usage.is_idle_in(from) {
            return;
        }
        let at = self.store.last_pose().filter(|pose| pose.map == from).map(|pose| pose.map_from_base);
        let localise = CommandKind::Localise { map: to, at };
        let (by, kinds) = match self.usage.controlled_by() {
            None => (Principal::operator(ClientId(upload.0)), vec![localise, CommandKind::ReleaseControl]),
            Some(owner) if owner == by.client => (by.clone(), vec![localise]),
            Some(_) => return,
        };
        for (number, kind) in (1..).zip(kinds) {
            let id = CommandId(Uuid::from_u128(upload.0.as_u128().wrapping_add(number)));
            (self.command)(Command { id, by: by.clone(), kind });
        }
    }
}

/// Changes whose map is one and the same.
fn of_one_map(changes: Vec<SceneChange>) -> Result<AcceptedChanges, &'static str> {
    let map = changes.first().ok_or(texts::NO_SUCH_CHANGES)?.map;
    if changes.iter().any(|change| change.map != map) {
        return Err(texts::CHANGES_OF_SEVERAL_MAPS);
    }
    let runs = changes.iter().map(|change| change.after).collect();
    Ok(AcceptedChanges { map, changes, runs })
}

/// Notes what is normal in the version `to` of the map `from`. The other changes of that map are taken over: they are where they were.
fn edit_of(site: &Site, id: EditId, from: MapId, to: MapId, normal: &BTreeSet<SceneChangeId>) -> Edit {
    let mut edit = Edit { id, changes: Vec::new() };
    let mut put = |change: SceneChange| {
        edit.changes.extend(site.put(id, Object::SceneChange(change)).changes);
    };
    let mut others: Vec<&SceneChange> = Vec::new();
    for change in site.scene_changes().filter(|change| change.map == from) {
        if normal.contains(&change.id) {
            put(SceneChange { review: ReviewState::Normal { map: to }, ..change.clone() });
        } else {
            others.push(change);
        }
    }
    others.retain(|change| !matches!(change.review, ReviewState::Normal { .. }));
    others.sort_by_key(|change| (Reverse(change.last_seen), change.id));
    for change in others.into_iter().take(CONFIG.max_taken_over) {
        put(SceneChange { map: to, ..change.clone() });
    }
    edit
}

#[cfg(test)]
#[path = "new_normal_tests.rs"]
mod tests;
