//! The thread that has runs compared, and the queue of runs that have ended.
//!
//! | what waits | policy |
//! | --- | --- |
//! | runs that have ended | one that finds the queue full is compared after the next start |

use super::baseline::{Baseline, BaselineConfig, MARKER, find_baseline, note_comparison};
use super::site_edit::{Comparison, SiteChangesConfig, edit_with_changes};
use super::texts;
use crate::clock::RobotClock;
use crate::ledger::{LedgerInbox, SiteWork, refusal_reason};
use crate::mailbox::Mailbox;
use api::EditOutcome;
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, TryRecvError};
use messages::{Principal, Publication, Severity};
use ports::{ChangeFinder, FoundChange, FoundChanges, error_with_causes};
use site_model::{EarlierVisit, RunId, SceneChangeClouds, SceneChangeKind, Utc};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use store::{BlobsConfig, ChangedSince, Store, StoreError};
use uuid::Uuid;
use vocab::{BlobHash, ClientId};
use watchdog::{BEAT_PERIOD, Heartbeat};

/// Parameters of the comparisons.
#[derive(Clone, Copy, Debug)]
struct SceneChangesConfig {
    /// Runs that may wait: more than the stack remembers of those that have ended. Chosen: four times that.
    max_waiting: usize,
    /// Objects of one comparison that are kept, the largest. A robot that was localised wrongly sees everything changed. Chosen: nobody looks through more.
    max_objects: usize,
    /// A comparison that takes longer hangs. Chosen: a comparison takes seconds to minutes (docs/benchmarks/changes.md), with low priority.
    max_duration: Duration,
}

const CONFIG: SceneChangesConfig =
    SceneChangesConfig { max_waiting: 256, max_objects: 200, max_duration: Duration::from_secs(3_600) };

/// Name of the folder of a comparison, in that of the clouds of its run.
const FOLDER: &str = "comparison";

/// The control loop's end: notes the runs that have ended.
pub struct SceneChangeQueue {
    runs: Sender<RunId>,
    handed_in: BTreeSet<RunId>,
}

/// The thread's end.
pub struct SceneChangeWorker {
    pub finder: Box<dyn ChangeFinder>,
    pub store: Arc<Store>,
    pub ledger: Arc<LedgerInbox>,
    pub runs: Receiver<RunId>,
    pub mailbox: Arc<Mailbox>,
    pub clock: Arc<RobotClock>,
    /// Disconnected when the core ends.
    pub stop: Receiver<()>,
}

impl SceneChangeQueue {
    /// Both ends.
    pub fn new() -> (Self, Receiver<RunId>) {
        let (runs, inbox) = crossbeam_channel::bounded(CONFIG.max_waiting);
        (Self { runs, handed_in: BTreeSet::new() }, inbox)
    }

    /// Follows what the stack publishes. Never blocks.
    pub fn watch(&mut self, publication: &Publication) {
        let Publication::Missions(status) = publication else { return };
        // The newest are first.
        for run in status.ended.iter().rev() {
            if !self.handed_in.contains(&run.run) && self.runs.try_send(run.run).is_ok() {
                self.handed_in.insert(run.run);
            }
        }
        // Memory does not grow with the runs of months.
        self.handed_in.retain(|run| status.ended.iter().any(|ended| ended.run == *run));
    }
}

impl SceneChangeWorker {
    /// Works until the core ends.
    pub fn run(self, heartbeat: &Heartbeat) {
        // What a comparison has left that a crash cut short: its links keep clouds on the disk.
        let _ = fs::remove_dir_all(self.store.dir().background());
        while !self.is_ending() {
            heartbeat.beat();
            match self.runs.recv_timeout(BEAT_PERIOD) {
                Ok(run) => {
                    let _job = heartbeat.begin_long_job(CONFIG.max_duration);
                    self.compare(run);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
        }
    }

    fn is_ending(&self) -> bool {
        matches!(self.stop.try_recv(), Err(TryRecvError::Disconnected))
    }

    /// Compares a run, unless that was done, and says so.
    fn compare(&self, run: RunId) {
        let folder = self.store.dir().clouds_of_run(run);
        if !folder.exists() || folder.join(MARKER).exists() {
            return;
        }
        let baseline = find_baseline(&self.store, run, &BaselineConfig::default());
        let compared = match baseline.map_err(|error| format!("{}.", error_with_causes(&error))) {
            Ok(None) => Ok(None),
            Ok(Some(baseline)) => {
                let out = folder.join(FOLDER);
                let found = self.compare_with(run, &baseline, &folder, &out);
                // A folder that cannot be removed goes with the clouds of the run, or is made anew.
                let _ = fs::remove_dir_all(&out);
                let _ = fs::remove_dir_all(self.store.dir().background());
                found.map(|changes| Some((baseline, changes)))
            }
            Err(reason) => Err(reason),
        };
        if self.is_ending() {
            // It is compared after the next start.
            return;
        }
        if let Err(reason) = &compared {
            self.tell(Severity::Warning, texts::not_compared(reason));
        }
        let problem = compared.as_ref().err().cloned();
        let (baseline, changes) = compared.ok().flatten().unzip();
        let noted =
            note_comparison(&self.store, run, baseline.as_ref(), changes.unwrap_or_default(), problem);
        if let Err(error) = noted {
            tracing::warn!("{}", error_with_causes(&error));
        }
    }

    /// Compares a run with an earlier visit and puts what changed into the site. Returns what changed, or a sentence.
    fn compare_with(
        &self,
        run: RunId,
        baseline: &Baseline,
        folder: &Path,
        out: &Path,
    ) -> Result<Vec<ChangedSince>, String> {
        let before = match baseline.before {
            EarlierVisit::Run(_) => {
                self.put_background(baseline).map_err(|error| format!("{}.", error_with_causes(&error)))?
            }
            EarlierVisit::Map(map) => self.store.dir().map(map),
        };
        let mut found = self.finder.compare(&before, folder, out, &mut || self.is_ending())?;
        let count = found.objects.len();
        if count > CONFIG.max_objects {
            self.tell(Severity::Warning, texts::too_many_changes(count, CONFIG.max_objects));
            found.objects.truncate(CONFIG.max_objects);
        }
        if count == 0 {
            let is_against_map = matches!(baseline.before, EarlierVisit::Map(_));
            self.tell(Severity::Info, texts::nothing_changed(is_against_map));
            return Ok(Vec::new());
        }
        let changes = found.objects.iter().map(|object| changed_since(object, baseline)).collect();
        let clouds = self.keep_clouds(&found).unwrap_or_else(|reason| {
            self.tell(Severity::Warning, texts::clouds_not_kept(&reason));
            vec![None; found.objects.len()]
        });
        let comparison = Comparison {
            run,
            map: baseline.map,
            before: baseline.before,
            at: Utc(baseline.ended_utc_ns),
            found: found.objects.into_iter().zip(clouds).collect(),
        };
        self.edit_site(comparison)?;
        Ok(changes)
    }

    /// Puts what was last seen on earlier runs into one folder, and returns that.
    fn put_background(&self, baseline: &Baseline) -> Result<PathBuf, StoreError> {
        let folder = self.store.dir().background();
        self.store.put_background(&folder, &baseline.clouds, baseline.changes.clone())?;
        Ok(folder)
    }

    /// Stores the clouds of a comparison. Fails with a clause.
    fn keep_clouds(&self, found: &FoundChanges) -> Result<Vec<Option<SceneChangeClouds>>, String> {
        let keep = |file: &Path| -> Result<BlobHash, String> {
            let bytes = fs::read(file).map_err(|error| error.to_string())?;
            self.store.put_blob(&bytes, &BlobsConfig::default()).map_err(|error| error_with_causes(&error))
        };
        let (changed, unchanged) = (keep(&found.changed)?, keep(&found.unchanged)?);
        let of_object = |object: &FoundChange| {
            keep(&object.cloud).map(|object| Some(SceneChangeClouds { object, changed, unchanged }))
        };
        found.objects.iter().map(of_object).collect()
    }

    /// Waits until the changes are in the ledger. Fails with a sentence.
    fn edit_site(&self, comparison: Comparison) -> Result<(), String> {
        let (outcome, applied) = crossbeam_channel::bounded(1);
        let is_against_map = matches!(comparison.before, EarlierVisit::Map(_));
        let found = comparison.found.len();
        let counted = Arc::new(Mutex::new(0));
        let of_edit = Arc::clone(&counted);
        self.ledger.change_site(SiteWork {
            by: Principal::operator(ClientId(Uuid::nil())),
            make: Box::new(move |site| {
                let (edit, new) = edit_with_changes(site, &comparison, &SiteChangesConfig::default());
                *of_edit.lock().unwrap_or_else(PoisonError::into_inner) = new;
                edit
            }),
            done: Box::new(move |result| {
                // Whoever waited may have given up.
                let _ = outcome.send(result);
            }),
        })?;
        match applied.recv() {
            Ok(EditOutcome::Applied { .. }) => {
                let new = *counted.lock().unwrap_or_else(PoisonError::into_inner);
                self.tell(Severity::Info, texts::changes_found(new, found - new, is_against_map));
                Ok(())
            }
            Ok(EditOutcome::Refused(refusal)) => Err(texts::site_refused(&refusal_reason(refusal))),
            Err(_) => Err(texts::CORE_ENDS.to_owned()),
        }
    }

    fn tell(&self, severity: Severity, text: String) {
        self.mailbox.notice(self.clock.now(), severity, text);
    }
}

/// What older clouds do not show of an object.
fn changed_since(object: &FoundChange, baseline: &Baseline) -> ChangedSince {
    let (was, is) = match object.kind {
        SceneChangeKind::Appeared => (None, Some(object.place)),
        SceneChangeKind::Removed => (Some(object.place), None),
        SceneChangeKind::Moved { from } => (Some(from), Some(object.place)),
    };
    ChangedSince { utc_ns: baseline.began_utc_ns, was, is }
}

#[cfg(test)]
#[path = "worker_tests.rs"]
mod tests;
