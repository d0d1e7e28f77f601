//! Runs of missions in the ledger: their steps, results, and the slots of schedules that were used.

use super::documents::json;
use super::rows::{Fault, integer, or_null, text};
use super::schema::{FIRINGS, MISSION_EVENTS, PICTURE_COMPARISONS, POINT_OF_RESULT, RESULTS, RUNS, STEPS};
use super::{Ledger, LedgerWriter};
use crate::StoreError;
use api::{MAX_PAGE, RunFilter, StoredResult, StoredRun, StoredSlot, StoredStep};
use messages::{FiringRecord, LEDGER_BODY_VERSION, LedgerEvent, ResultRecord, RunRecord, StepRecord};
use rusqlite::types::Value;
use rusqlite::{Params, params};
use site_model::{InspectionPointId, MissionEvent, RunId, ScheduleId};
use vocab::Stamp;

/// Events of missions that are read at once.
const EVENTS_OF_PAGE: u32 = 10_000;

/// A run that has not ended, with its steps. It goes on after a restart.
#[derive(Clone, Debug, PartialEq)]
pub struct UnfinishedRun {
    /// The run.
    pub run: StoredRun,
    /// All attempts of its steps.
    pub steps: Vec<StoredStep>,
}

impl LedgerWriter<'_> {
    /// Writes an event of a run. Others are not stored here. Returns the result with its number, if the event is one.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn put_event(&self, event: &LedgerEvent, at: Stamp) -> Result<Option<StoredResult>, StoreError> {
        let put = match event {
            LedgerEvent::Result(record) => {
                return self.put_result(record, at).map(Some).map_err(|fault| self.error(fault));
            }
            LedgerEvent::Run(record) => self.put_run(record, at),
            LedgerEvent::Step(record) => self.put_step(record, at),
            LedgerEvent::Firing(record) => self.put_firing(record, at),
            LedgerEvent::Mission(event) => self.put_mission_event(event, at),
            LedgerEvent::Goal(_) | LedgerEvent::StopLatch(_) | LedgerEvent::Site(_) => Ok(()),
        };
        put.map(|()| None).map_err(|fault| self.error(fault))
    }

    fn put_run(&self, record: &RunRecord, at: Stamp) -> Result<(), Fault> {
        let run = record.run.to_string();
        let kept = RUNS
            .read(self.transaction, "WHERE run = ?", [&run], |row| Some((row[0].clone(), row[7].clone())))?;
        let (seq, began) = match kept.into_iter().next() {
            Some(kept) => kept,
            None => (self.next_seq(RUNS.name)?, Value::from(at.nanos())),
        };
        let values = [
            seq,
            Value::from(run),
            Value::from(record.mission.to_string()),
            Value::from(record.state.clone()),
            Value::from(i64::from(record.is_ended)),
            Value::from(i64::from(LEDGER_BODY_VERSION)),
            Value::from(record.body.clone()),
            began,
            Value::from(at.nanos()),
        ];
        RUNS.put(self.transaction, &values)?;
        self.put_audit(None, &format!("run {}", record.run), &record.state, at)
    }

    fn put_step(&self, record: &StepRecord, at: Stamp) -> Result<(), Fault> {
        let key = params![record.run.to_string(), record.step, record.attempt];
        let rest = "WHERE run = ? AND step = ? AND attempt = ?";
        let intended = STEPS.read(self.transaction, rest, key, |row| integer(&row[6]))?;
        let values = [
            Value::from(record.run.to_string()),
            Value::from(i64::from(record.step)),
            Value::from(i64::from(record.attempt)),
            Value::from(record.state.clone()),
            Value::from(i64::from(LEDGER_BODY_VERSION)),
            Value::from(record.body.clone()),
            Value::from(intended.first().copied().unwrap_or(at.nanos())),
            or_null(record.is_done.then_some(at.nanos())),
        ];
        STEPS.put(self.transaction, &values)
    }

    fn put_result(&self, record: &ResultRecord, at: Stamp) -> Result<StoredResult, Fault> {
        let seq = self.next_seq(RESULTS.name)?;
        let number = integer(&seq).and_then(|seq| seq.try_into().ok()).ok_or(Fault::NotUnderstood)?;
        let values = [
            seq,
            Value::from(record.run.to_string()),
            Value::from(i64::from(record.step)),
            Value::from(i64::from(record.attempt)),
            Value::from(record.kind.clone()),
            or_null(record.blob.map(|hash| hash.to_vec())),
            Value::from(i64::from(LEDGER_BODY_VERSION)),
            Value::from(record.body.clone()),
            Value::from(at.nanos()),
        ];
        RESULTS.put(self.transaction, &values)?;
        let ResultRecord { run, step, attempt, kind, blob, body } = record.clone();
        Ok(StoredResult { number, run, step, attempt, kind, blob, body, comparison: None, at })
    }

    /// Writes how the picture of a result differs from an earlier one, a `site_model::PictureComparison` as JSON.
    ///
    /// # Errors
    /// When the disk fails.
    pub fn put_picture_comparison(&self, result: u64, body: &str, at: Stamp) -> Result<(), StoreError> {
        let values = [
            Value::from(i64::try_from(result).unwrap_or(i64::MAX)),
            Value::from(i64::from(LEDGER_BODY_VERSION)),
            Value::from(body.to_owned()),
            Value::from(at.nanos()),
        ];
        PICTURE_COMPARISONS.put(self.transaction, &values).map_err(|fault| self.error(fault))
    }

    fn put_firing(&self, record: &FiringRecord, at: Stamp) -> Result<(), Fault> {
        let values = [
            Value::from(record.schedule.to_string()),
            Value::from(record.due_utc_ns),
            or_null(record.run.map(|run| run.to_string())),
            Value::from(record.outcome.clone()),
            Value::from(i64::from(LEDGER_BODY_VERSION)),
            Value::from(record.body.clone()),
            Value::from(at.nanos()),
        ];
        FIRINGS.put_new(self.transaction, &values).map(drop)
    }

    fn put_mission_event(&self, event: &MissionEvent, at: Stamp) -> Result<(), Fault> {
        let values = [
            self.next_seq(MISSION_EVENTS.name)?,
            or_null(event.kind.run().map(|run| run.to_string())),
            Value::from(i64::from(LEDGER_BODY_VERSION)),
            Value::from(json(event)),
            Value::from(at.nanos()),
        ];
        MISSION_EVENTS.put(self.transaction, &values)
    }

    fn next_seq(&self, table: &str) -> Result<Value, Fault> {
        let sql = format!("SELECT coalesce(max(seq), 0) + 1 FROM {table}");
        let next: i64 = self.transaction.prepare_cached(&sql)?.query_row([], |row| row.get(0))?;
        Ok(Value::from(next))
    }
}

impl Ledger {
    /// Runs that were asked for before `before`, the newest first.
    ///
    /// # Errors
    /// When the database cannot be read.
    pub fn runs(
        &self,
        filter: &RunFilter,
        before: Option<RunId>,
        limit: u32,
    ) -> Result<Vec<StoredRun>, StoreError> {
        let rest = "WHERE (?1 IS NULL OR seq < (SELECT seq FROM runs WHERE run = ?1)) AND (?2 IS NULL OR mission = ?2) \
                    AND (?3 IS NULL OR state = ?3) AND (?4 IS NULL OR began_ns >= ?4) AND (?5 IS NULL OR began_ns < ?5) \
                    ORDER BY seq DESC LIMIT ?6";
        let state = filter.state.map(|state| json(&state).trim_matches('"').to_owned());
        let parameters = params![
            before.map(|run| run.to_string()),
            filter.mission.map(|mission| mission.to_string()),
            state,
            filter.from.map(Stamp::nanos),
            filter.to.map(Stamp::nanos),
            limit.clamp(1, MAX_PAGE)
        ];
        self.read_runs(rest, parameters)
    }

    /// A run; `None`: there is no such run.
    ///
    /// # Errors
    /// When the database cannot be read.
    pub fn run(&self, run: RunId) -> Result<Option<StoredRun>, StoreError> {
        Ok(self.read_runs("WHERE run = ?", [run.to_string()])?.pop())
    }

    /// Runs that have not ended, in the order in which they began.
    ///
    /// # Errors
    /// When the database cannot be read.
    pub fn unfinished_runs(&self) -> Result<Vec<UnfinishedRun>, StoreError> {
        let runs = self.read_runs("WHERE is_ended = 0 ORDER BY seq", [])?;
        let with_steps = |run: StoredRun| {
            let steps = self.read_steps("WHERE run = ? ORDER BY step, attempt", [run.run.to_string()])?;
            Ok(UnfinishedRun { run, steps })
        };
        runs.into_iter().map(with_steps).collect()
    }

    /// Attempts of a run's steps after `after`, in their order.
    ///
    /// # Errors
    /// When the database cannot be read.
    pub fn steps(
        &self,
        run: RunId,
        after: Option<(u32, u32)>,
        limit: u32,
    ) -> Result<Vec<StoredStep>, StoreError> {
        let (step, attempt) = after.map_or((-1, -1), |(step, attempt)| (i64::from(step), i64::from(attempt)));
        let rest = "WHERE run = ? AND (step, attempt) > (?, ?) ORDER BY step, attempt LIMIT ?";
        self.read_steps(rest, params![run.to_string(), step, attempt, limit.clamp(1, MAX_PAGE)])
    }

    /// Results of a run after the number `after`, in the order in which they were stored.
    ///
    /// # Errors
    /// When the database cannot be read.
    pub fn results(
        &self,
        run: RunId,
        after: Option<u64>,
        limit: u32,
    ) -> Result<Vec<StoredResult>, StoreError> {
        let after = after.map_or(0, |after| i64::try_from(after).unwrap_or(i64::MAX));
        let parameters = params![run.to_string(), after, limit.clamp(1, MAX_PAGE)];
        self.read_results("WHERE run = ? AND seq > ? ORDER BY seq LIMIT ?", parameters)
    }

    /// Results at an inspection point before the number `before`, the newest first.
    ///
    /// # Errors
    /// When the database cannot be read.
    pub fn point_results(
        &self,
        point: InspectionPointId,
        before: Option<u64>,
        limit: u32,
    ) -> Result<Vec<StoredResult>, StoreError> {
        let before = before.map_or(i64::MAX, |before| i64::try_from(before).unwrap_or(i64::MAX));
        let rest = format!("WHERE {POINT_OF_RESULT} = ? AND seq < ? ORDER BY seq DESC LIMIT ?");
        self.read_results(&rest, params![point.to_string(), before, limit.clamp(1, MAX_PAGE)])
    }

    /// A result by its number.
    ///
    /// # Errors
    /// When the database cannot be read.
    pub fn result(&self, number: u64) -> Result<Option<StoredResult>, StoreError> {
        let number = i64::try_from(number).unwrap_or(i64::MAX);
        self.read_results("WHERE seq = ?", [number]).map(|found| found.into_iter().next())
    }

    /// The next result of this kind at any inspection point after the number `after`.
    ///
    /// # Errors
    /// When the database cannot be read.
    pub fn next_point_result(&self, kind: &str, after: u64) -> Result<Option<StoredResult>, StoreError> {
        let rest =
            format!("WHERE seq > ? AND kind = ? AND {POINT_OF_RESULT} IS NOT NULL ORDER BY seq LIMIT 1");
        let after = i64::try_from(after).unwrap_or(i64::MAX);
        self.read_results(&rest, params![after, kind]).map(|found| found.into_iter().next())
    }

    /// The newest result of this kind at an inspection point before the number `before`.
    ///
    /// # Errors
    /// When the database cannot be read.
    pub fn earlier_point_result(
        &self,
        point: InspectionPointId,
        kind: &str,
        before: u64,
    ) -> Result<Option<StoredResult>, StoreError> {
        let rest = format!("WHERE {POINT_OF_RESULT} = ? AND seq < ? AND kind = ? ORDER BY seq DESC LIMIT 1");
        let before = i64::try_from(before).unwrap_or(i64::MAX);
        self.read_results(&rest, params![point.to_string(), before, kind])
            .map(|found| found.into_iter().next())
    }

    /// Number of the newest result whose picture was compared; none: no picture was.
    ///
    /// # Errors
    /// When the database cannot be read.
    pub fn last_compared_result(&self) -> Result<Option<u64>, StoreError> {
        let take = |row: &[Value]| integer(&row[0])?.try_into().ok();
        let found =
            PICTURE_COMPARISONS.read(&self.connection, "ORDER BY result DESC LIMIT 1", params![], take);
        found.map(|found| found.into_iter().next()).map_err(|fault| self.error(fault))
    }

    /// Number of the newest result; 0: there is none.
    ///
    /// # Errors
    /// When the database cannot be read.
    pub fn newest_result(&self) -> Result<u64, StoreError> {
        let newest = self.read_results("ORDER BY seq DESC LIMIT 1", params![])?;
        Ok(newest.first().map_or(0, |result| result.number))
    }

    /// Events of missions after the number `after`, in the order in which they were stored, each with its number.
    ///
    /// # Errors
    /// When the database cannot be read.
    pub fn mission_events(&self, after: u64, limit: u32) -> Result<Vec<(u64, MissionEvent)>, StoreError> {
        let parameters = params![i64::try_from(after).unwrap_or(i64::MAX), limit];
        let take = |row: &[Value]| {
            Some((integer(&row[0])?.try_into().ok()?, serde_json::from_str(text(&row[3])?).ok()?))
        };
        let rest = "WHERE seq > ? ORDER BY seq LIMIT ?";
        MISSION_EVENTS.read(&self.connection, rest, parameters, take).map_err(|fault| self.error(fault))
    }

    /// The events that a mission runner needs after a restart, see [`missions::events_for_restart`]. Linear in all events that were ever stored; memory holds
    /// a page of them beside those that are needed.
    ///
    /// # Errors
    /// When the database cannot be read.
    pub fn events_for_restart(&self) -> Result<Vec<MissionEvent>, StoreError> {
        let mut needed = Vec::new();
        let mut after = 0;
        loop {
            let page = self.mission_events(after, EVENTS_OF_PAGE)?;
            let Some((last, _)) = page.last() else { return Ok(needed) };
            after = *last;
            needed.extend(page.into_iter().map(|(_, event)| event));
            needed = missions::events_for_restart(&needed);
        }
    }

    /// Slots of all schedules that were decided, those due last first, from the one after `before`.
    ///
    /// # Errors
    /// When the database cannot be read.
    pub fn slots(
        &self,
        before: Option<(Stamp, ScheduleId)>,
        limit: u32,
    ) -> Result<Vec<StoredSlot>, StoreError> {
        let rest =
            "WHERE ?1 IS NULL OR (due_ns, schedule) < (?1, ?2) ORDER BY due_ns DESC, schedule DESC LIMIT ?3";
        let (due, schedule) = before.unzip();
        let schedule = schedule.map(|schedule| schedule.to_string());
        let parameters = params![due.map(Stamp::nanos), schedule, limit.clamp(1, MAX_PAGE)];
        let take = |row: &[Value]| {
            Some(StoredSlot {
                schedule: text(&row[0])?.parse().ok()?,
                due: Stamp::from_nanos(integer(&row[1])?),
                run: text(&row[2]).and_then(|run| run.parse().ok()),
                outcome: text(&row[3])?.to_owned(),
                body: text(&row[5])?.to_owned(),
            })
        };
        FIRINGS.read(&self.connection, rest, parameters, take).map_err(|fault| self.error(fault))
    }

    fn read_results(&self, rest: &str, parameters: impl Params) -> Result<Vec<StoredResult>, StoreError> {
        let take = |row: &[Value]| {
            let blob = match &row[5] {
                Value::Blob(bytes) => Some(bytes.as_slice().try_into().ok()?),
                _ => None,
            };
            Some(StoredResult {
                number: integer(&row[0])?.try_into().ok()?,
                run: text(&row[1])?.parse().ok()?,
                step: integer(&row[2])?.try_into().ok()?,
                attempt: integer(&row[3])?.try_into().ok()?,
                kind: text(&row[4])?.to_owned(),
                blob,
                body: text(&row[7])?.to_owned(),
                comparison: None,
                at: Stamp::from_nanos(integer(&row[8])?),
            })
        };
        let results = RESULTS.read(&self.connection, rest, parameters, take);
        results.and_then(|results| self.with_comparisons(results)).map_err(|fault| self.error(fault))
    }

    /// Adds what is known of the pictures of results. A comparison of a later program is left out: it is not needed to read the result.
    fn with_comparisons(&self, mut results: Vec<StoredResult>) -> Result<Vec<StoredResult>, Fault> {
        for result in &mut results {
            let number = i64::try_from(result.number).unwrap_or(i64::MAX);
            let take = |row: &[Value]| Some((integer(&row[1])?, text(&row[2])?.to_owned()));
            let found = PICTURE_COMPARISONS.read(&self.connection, "WHERE result = ?", [number], take)?;
            let found = found.into_iter().find(|(version, _)| *version <= i64::from(LEDGER_BODY_VERSION));
            result.comparison = found.map(|(_, body)| body);
        }
        Ok(results)
    }

    fn read_runs(&self, rest: &str, parameters: impl Params) -> Result<Vec<StoredRun>, StoreError> {
        let take = |row: &[Value]| {
            Some(StoredRun {
                run: text(&row[1])?.parse().ok()?,
                mission: text(&row[2])?.parse().ok()?,
                state: text(&row[3])?.to_owned(),
                is_ended: integer(&row[4])? != 0,
                body: text(&row[6])?.to_owned(),
                began: Stamp::from_nanos(integer(&row[7])?),
                changed: Stamp::from_nanos(integer(&row[8])?),
            })
        };
        RUNS.read(&self.connection, rest, parameters, take).map_err(|fault| self.error(fault))
    }

    fn read_steps(&self, rest: &str, parameters: impl Params) -> Result<Vec<StoredStep>, StoreError> {
        let take = |row: &[Value]| {
            Some(StoredStep {
                step: integer(&row[1])?.try_into().ok()?,
                attempt: integer(&row[2])?.try_into().ok()?,
                state: text(&row[3])?.to_owned(),
                body: text(&row[5])?.to_owned(),
                intended: Stamp::from_nanos(integer(&row[6])?),
                done: integer(&row[7]).map(Stamp::from_nanos),
            })
        };
        STEPS.read(&self.connection, rest, parameters, take).map_err(|fault| self.error(fault))
    }
}
