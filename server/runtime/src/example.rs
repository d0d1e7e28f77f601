//! The example: a site to try at once. It is made by an [`ExampleMaker`](ports::ExampleMaker) in another process, on the import thread. Its map and its objects then
//! go the way of those of a person: the store adopts the map, and the ledger applies one edit.

use crate::imports::{ImportWorker, store_reason};
use crate::ledger::{SiteWork, refusal_reason};
use crate::texts;
use api::{EditOutcome, ImportStage, MapSummary};
use crossbeam_channel::RecvTimeoutError;
use messages::{Command, CommandKind, Principal};
use ports::ExampleRequest;
use site_model::{Change, Edit, EditId, Object, Site, SiteSettings};
use std::ops::ControlFlow;
use std::time::Duration;
use uuid::Uuid;
use vocab::{ClientId, CommandId, MapId, UploadId};

/// Parameters of making the example.
struct ExampleConfig {
    /// Longest wait for the ledger. It writes an edit within some milliseconds. Chosen: after a minute its disk has failed.
    ledger_timeout: Duration,
}

const CONFIG: ExampleConfig = ExampleConfig { ledger_timeout: Duration::from_secs(60) };

impl ImportWorker {
    /// Makes the example. Map and site are as before if it fails.
    ///
    /// # Errors
    /// Why it was not made, a sentence for people.
    pub(crate) fn make_example(
        &self,
        upload: UploadId,
        by: &Principal,
        request: ExampleRequest<'_>,
        progress: &mut dyn FnMut(ImportStage, f32) -> ControlFlow<()>,
    ) -> Result<MapSummary, String> {
        let maker = self.example_maker.as_deref().ok_or(texts::NO_EXAMPLE)?;
        if let Some(reason) = self.refusal_of_example(by, request.name)? {
            return Err(reason.to_owned());
        }
        if progress(ImportStage::Walking, 0.0).is_break() {
            return Err(texts::IMPORT_CANCELLED.to_owned());
        }
        let mut objects = maker.make(&request, progress)?;
        let is_of_robot = self.robot_site.as_deref() == Some(maker.site());
        if !is_of_robot {
            hold_schedules(&mut objects);
        }
        let map = self.adopt(upload, request.out)?;
        let edit = EditId(upload.0);
        self.change_site(by, move |site| edit_of(site, edit, objects))?;
        if is_of_robot {
            self.localise(upload, map.id);
        }
        Ok(map)
    }

    /// Why the example cannot be made now, if so.
    fn refusal_of_example(&self, by: &Principal, name: &str) -> Result<Option<&'static str>, String> {
        if self.usage.is_mapping() {
            return Ok(Some(texts::EXAMPLE_WHILE_MAPPING));
        }
        let maps = self.store.maps().map_err(|error| store_reason(&error))?;
        if maps.iter().any(|map| map.name == name) {
            return Ok(Some(texts::EXAMPLE_EXISTS));
        }
        let (sender, answer) = crossbeam_channel::bounded(1);
        self.change_site(by, move |site| {
            let _ = sender.send(site.nodes().next().is_none() && site.missions().next().is_none());
            Edit { id: EditId(Uuid::nil()), changes: Vec::new() }
        })?;
        Ok((answer.try_recv() != Ok(true)).then_some(texts::SITE_IS_NOT_EMPTY))
    }

    /// Changes the site by one edit, and waits until it is durable.
    pub(crate) fn change_site(
        &self,
        by: &Principal,
        make: impl FnOnce(&Site) -> Edit + Send + 'static,
    ) -> Result<(), String> {
        let (sender, outcome) = crossbeam_channel::bounded(1);
        let work = SiteWork {
            by: by.clone(),
            make: Box::new(make),
            done: Box::new(move |outcome| {
                let _ = sender.send(outcome);
            }),
        };
        self.ledger.change_site(work).map_err(str::to_owned)?;
        match outcome.recv_timeout(CONFIG.ledger_timeout) {
            Ok(EditOutcome::Applied { .. }) => Ok(()),
            Ok(EditOutcome::Refused(refusal)) => Err(texts::example_not_stored(&refusal_reason(refusal))),
            // The ledger's thread has ended, or its disk hangs.
            Err(RecvTimeoutError::Timeout) => Err(texts::example_not_stored(texts::DISK_TOO_SLOW)),
            Err(RecvTimeoutError::Disconnected) => Err(texts::PLATFORM_ENDING.to_owned()),
        }
    }

    /// Lets the simulated robot find its place in the map, unless somebody controls it. Control is free again afterwards.
    fn localise(&self, upload: UploadId, map: MapId) {
        let by = Principal::operator(ClientId(upload.0));
        let kinds = [CommandKind::Localise { map, at: None }, CommandKind::ReleaseControl];
        for (number, kind) in (1..).zip(kinds) {
            let id = CommandId(Uuid::from_u128(upload.0.as_u128().wrapping_add(number)));
            (self.command)(Command { id, by: by.clone(), kind });
        }
    }
}

/// The robot does not know where it is in this map, so nothing of it shall begin by itself.
fn hold_schedules(objects: &mut [Object]) {
    for object in objects {
        if let Object::Schedule(schedule) = object {
            schedule.is_paused = true;
        }
    }
}

/// Puts the objects into the site. What people have set for the whole site stays, except the map.
fn edit_of(site: &Site, id: EditId, objects: Vec<Object>) -> Edit {
    let put = |object: Object| {
        let object = match (object, site.settings()) {
            (Object::Settings(SiteSettings { map, .. }), Some(known)) => {
                Object::Settings(SiteSettings { map, ..known.clone() })
            }
            (object, _) => object,
        };
        Change::Put { base: site.revision(object.id()), object }
    };
    Edit { id, changes: objects.into_iter().map(put).collect() }
}

#[cfg(test)]
#[path = "example_tests.rs"]
mod tests;
