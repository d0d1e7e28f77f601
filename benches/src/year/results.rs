//! A year of results as the platform stores it: runs of one mission, a photo with readings at each point, and what has changed.

use anyhow::Result;
use messages::{LedgerEvent, ResultRecord, RunRecord};
use serde_json::json;
use site_model::{
    Alert, AlertCause, AlertId, AlertSeverity, AlertState, EarlierVisit, Edit, EditId, InspectionPointId,
    MissionId, Object, OrientedBox, PhysicalObject, PhysicalObjectId, ReviewState, RunId, SceneChange,
    SceneChangeId, SceneChangeKind, Site, Utc,
};
use std::path::Path;
use store::{BlobsConfig, EditRecord, Ledger, Store};
use uuid::Uuid;
use vocab::{MapId, Stamp, Vec3};

/// Inspection points of the site, and results of a run.
const POINTS: u64 = 50;
/// Nanoseconds of a day.
pub(crate) const DAY_NS: i64 = 24 * 3_600_000_000_000;
/// When the year begins, nanoseconds since 1970 UTC.
const BEGIN_NS: i64 = 1_766_000_000_000_000_000;
/// Rows of one transaction.
const AT_ONCE: u64 = 1_000;
/// Changes of one thing.
const CHANGES_OF_THING: u64 = 4;
/// Bytes of the picture. Chosen: those of a photo of an inspection camera.
const PICTURE_BYTES: usize = 400_000;
/// One result in this number has raised an alert.
const RESULTS_OF_ALERT: u64 = 100;

/// How much a year has.
pub(crate) struct Year {
    pub(crate) results: u64,
    pub(crate) changes: u64,
}

pub(crate) fn point(number: u64) -> InspectionPointId {
    InspectionPointId(id(1, number))
}

pub(crate) fn run(number: u64) -> RunId {
    RunId(id(2, number))
}

pub(crate) fn change_id(number: u64) -> SceneChangeId {
    SceneChangeId(id(3, number))
}

fn id(kind: u128, number: u64) -> Uuid {
    Uuid::from_u128(kind << 64 | u128::from(number + 1))
}

impl Year {
    pub(crate) fn runs(&self) -> u64 {
        self.results.div_ceil(POINTS)
    }

    /// When its first and its last result were taken, nanoseconds since 1970 UTC.
    pub(crate) fn span_ns(&self) -> (i64, i64) {
        (BEGIN_NS, BEGIN_NS + 365 * DAY_NS)
    }

    /// When something was that comes at this share of the year.
    fn at_ns(&self, number: u64, of: u64) -> i64 {
        BEGIN_NS + (365.0 * DAY_NS as f64 * number as f64 / of.max(1) as f64) as i64
    }

    /// Writes all of it into a data folder. Returns the hash of the picture that all results have.
    pub(crate) fn write(&self, data: &Path) -> Result<String> {
        let store = Store::open(data)?;
        let hash = store.put_blob(&[0x55; PICTURE_BYTES], &BlobsConfig::default())?.to_string();
        let (mut ledger, state) = store.open_ledger()?;
        self.write_runs(&mut ledger, &hash)?;
        self.write_site(&mut ledger, state.site)?;
        Ok(hash)
    }

    fn write_runs(&self, ledger: &mut Ledger, hash: &str) -> Result<()> {
        let runs = self.runs();
        for first in (0..runs).step_by((AT_ONCE / POINTS) as usize) {
            ledger.write(|writer| {
                for number in first..runs.min(first + AT_ONCE / POINTS) {
                    let at_ns = self.at_ns(number, runs);
                    let state = if number.is_multiple_of(10) { "failed" } else { "succeeded" }.to_owned();
                    let mission = MissionId(id(4, 0));
                    let body = "{}".to_owned();
                    let record = RunRecord { run: run(number), mission, state, is_ended: true, body };
                    writer.put_event(&LedgerEvent::Run(record), Stamp::from_nanos(at_ns))?;
                    for step in 0..POINTS.min(self.results - number * POINTS) {
                        let at_ns = at_ns + step as i64 * 20_000_000_000;
                        let record = ResultRecord {
                            run: run(number),
                            step: step as u32,
                            attempt: 1,
                            kind: "photo".to_owned(),
                            blob: None,
                            body: body_of_photo(step, number, at_ns, hash),
                        };
                        writer.put_event(&LedgerEvent::Result(record), Stamp::from_nanos(at_ns))?;
                    }
                }
                Ok(())
            })?;
        }
        Ok(())
    }

    fn write_site(&self, ledger: &mut Ledger, mut site: Site) -> Result<()> {
        let changes = (0..self.changes).map(|number| Object::SceneChange(self.change(number)));
        let alerts = (0..self.results / RESULTS_OF_ALERT).map(|number| Object::Alert(self.alert(number)));
        let objects: Vec<Object> = changes.chain(alerts).collect();
        for (number, objects) in (0..).zip(objects.chunks(AT_ONCE as usize)) {
            let mut edit = Edit { id: EditId(id(5, number)), changes: Vec::new() };
            for object in objects {
                edit.changes.extend(site.put(edit.id, object.clone()).changes);
            }
            let applied = site.apply(&edit, edit.id).map_err(|error| anyhow::anyhow!("{error:?}"))?;
            let at = Stamp::from_nanos(BEGIN_NS);
            let record =
                EditRecord { revision: number + 1, edit: &edit, changes: &applied.revisions, by: None, at };
            ledger.write(|writer| writer.put_edit(&record))?;
        }
        Ok(())
    }

    fn change(&self, number: u64) -> SceneChange {
        let seen = Utc(self.at_ns(number, self.changes));
        let map = MapId(id(6, 0));
        let place = |shift: f64| OrientedBox {
            centre_m: Vec3::new((number % 97) as f64 + shift, (number % 31) as f64, 0.5),
            size_m: [0.2 + (number % 9) as f64 * 0.1, 0.3, 0.6],
            yaw_rad: 0.3,
        };
        let kind = match number % 3 {
            0 => SceneChangeKind::Appeared,
            1 => SceneChangeKind::Removed,
            _ => SceneChangeKind::Moved { from: place(2.0) },
        };
        let thing =
            PhysicalObject { id: PhysicalObjectId(id(7, number / CHANGES_OF_THING)), probability: 0.9 };
        SceneChange {
            id: change_id(number),
            map,
            kind,
            place: place(0.0),
            points: 150,
            confidence: 0.998,
            before: EarlierVisit::Map(map),
            after: run(number * self.runs() / self.changes.max(1)),
            first_seen: seen,
            last_seen: seen,
            times_seen: 1,
            review: if number.is_multiple_of(5) { ReviewState::Acknowledged } else { ReviewState::New },
            comment: String::new(),
            clouds: None,
            physical_object: Some(thing),
            descriptor: None,
        }
    }

    fn alert(&self, number: u64) -> Alert {
        let of = number * RESULTS_OF_ALERT;
        let raised = Utc(self.at_ns(of, self.results));
        let reason = "The needle is hidden.".to_owned();
        let cause = AlertCause::GaugeNotRead {
            point: point(of % POINTS),
            run: run(of / POINTS),
            result: of + 1,
            reason,
        };
        let closed = AlertState::Closed { by: "Ada".to_owned(), at: raised, remark: "cleaned".to_owned() };
        Alert {
            id: AlertId(id(8, number)),
            severity: AlertSeverity::Information,
            state: if number.is_multiple_of(4) { AlertState::Open } else { closed },
            cause,
            owner: "Ada".to_owned(),
            work_order: String::new(),
            comment: String::new(),
            first_raised: raised,
            last_raised: raised,
            times_raised: 1,
            recovered: None,
        }
    }
}

/// A result as an action reports it.
fn body_of_photo(step: u64, run: u64, at_ns: i64, hash: &str) -> String {
    let pose = json!({ "position": { "x": 1.5, "y": step as f64, "z": 0.0 }, "orientation": { "w": 1.0, "x": 0.0, "y": 0.0, "z": 0.0 } });
    let place = json!({ "map": id(6, 0), "map_from_base": pose, "covariance": vocab::Covariance6::default(), "quality": "good" });
    let pressure = 3.0 + 0.4 * (run as f64 * 0.3).sin();
    json!({
        "inspection_point": point(step),
        "value": {
            "at": { "robot_time": at_ns - BEGIN_NS, "utc_ns": at_ns, "is_synchronised": true },
            "place": place,
            "files": [{ "name": "photo.jpg", "media_type": "image/jpeg", "blob": hash, "bytes": PICTURE_BYTES }],
            "readings": [{ "name": "gauge", "value": pressure, "unit": "bar" }],
        },
    })
    .to_string()
}
