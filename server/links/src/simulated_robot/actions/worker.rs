//! The thread that renders pictures and makes readings, from snapshots of the simulation.

use super::picture::{EncodedPicture, encode_photo, encode_thermal};
use crate::stoppable_thread::StopSignal;
use crate::texts;
use crossbeam_channel::{Receiver, Sender, select};
use ports::{ActionEnd, ActionFile};
use sim::{
    AirReading, CameraConfig, CameraScene, CameraSnapshot, InstrumentEnvironment, InstrumentSnapshot,
    Intrinsics, SimulatedSite,
};
use site_model::{ActionReport, CameraReport, GammaSpectrum, Reading, ReportTime};
use std::collections::BTreeMap;
use std::sync::Arc;
use vocab::{ActionCallId, CameraAim, Stamp};

/// A spectrum in a file.
const SPECTRUM_NAME: &str = "spectrum.json";
const JSON: &str = "application/json";

/// Which camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PictureKind {
    Photo,
    Thermal,
}

/// Which instrument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Instrument {
    /// Temperature and humidity.
    Air,
    /// The gamma spectrometer.
    Gamma,
}

/// What the thread is to do.
pub(super) enum ActionJob {
    /// Take a picture, which ends its action.
    Picture {
        call: ActionCallId,
        kind: PictureKind,
        aim: CameraAim,
        snapshot: Box<CameraSnapshot>,
        at: Stamp,
    },
    /// Read an instrument that has measured for some seconds.
    Sample {
        call: ActionCallId,
        instrument: Instrument,
        snapshot: InstrumentSnapshot,
        seconds: f64,
        /// The instant, if this reading ends the action.
        ends: Option<Stamp>,
    },
}

/// An action that has ended.
pub(super) struct FinishedAction {
    pub(super) call: ActionCallId,
    pub(super) end: ActionEnd,
}

pub(super) struct Worker {
    site: Arc<SimulatedSite>,
    cameras: CameraConfig,
    /// Prepared with the first picture or reading.
    scene: Option<Arc<CameraScene>>,
    surroundings: Option<Arc<InstrumentEnvironment>>,
    measurements: BTreeMap<ActionCallId, Readings>,
}

/// What was read so far for an action.
enum Readings {
    Air(Vec<AirReading>),
    Gamma { seconds: f64, counts: Vec<u32> },
}

/// Bounds of measurements.
struct MeasurementConfig {
    /// Measurements that are kept at most. One whose action was cancelled is removed when newer ones come. Chosen: four of each open action.
    max_kept: usize,
}

const CONFIG: MeasurementConfig = MeasurementConfig { max_kept: 64 };

impl Worker {
    pub(super) fn new(site: &Arc<SimulatedSite>, cameras: CameraConfig) -> Self {
        Self {
            site: Arc::clone(site),
            cameras,
            scene: None,
            surroundings: None,
            measurements: BTreeMap::new(),
        }
    }

    /// Works until it is told to stop.
    pub(super) fn run(
        mut self,
        jobs: &Receiver<ActionJob>,
        finished: &Sender<FinishedAction>,
        stop: &StopSignal,
    ) {
        loop {
            let job = select! {
                recv(stop.0) -> _ => return,
                recv(jobs) -> job => job,
            };
            let Ok(job) = job else { return };
            if let Some(done) = self.work(job)
                && finished.send(done).is_err()
            {
                return;
            }
        }
    }

    fn work(&mut self, job: ActionJob) -> Option<FinishedAction> {
        match job {
            ActionJob::Picture { call, kind, aim, snapshot, at } => {
                Some(FinishedAction { call, end: self.picture(kind, &aim, *snapshot, at) })
            }
            ActionJob::Sample { call, instrument, snapshot, seconds, ends } => {
                self.sample(call, instrument, snapshot, seconds);
                let at = ends?;
                let end = match self.measurements.remove(&call)? {
                    Readings::Air(readings) => end_of_air(&readings, at),
                    Readings::Gamma { seconds, counts } => self.end_of_gamma(seconds, counts, at),
                };
                Some(FinishedAction { call, end })
            }
        }
    }

    fn scene(&mut self) -> Arc<CameraScene> {
        let site = &self.site;
        Arc::clone(self.scene.get_or_insert_with(|| Arc::new(CameraScene::new(Arc::clone(site)))))
    }

    fn surroundings(&mut self) -> Arc<InstrumentEnvironment> {
        let scene = self.scene();
        Arc::clone(self.surroundings.get_or_insert_with(|| Arc::new(InstrumentEnvironment::new(&scene))))
    }

    fn picture(
        &mut self,
        kind: PictureKind,
        aim: &CameraAim,
        mut snapshot: CameraSnapshot,
        at: Stamp,
    ) -> ActionEnd {
        let scene = self.scene();
        let (encoded, intrinsics) = match kind {
            PictureKind::Photo => {
                (encode_photo(&snapshot.picture(&scene, aim)), self.cameras.intrinsics(aim.zoom))
            }
            PictureKind::Thermal => {
                (encode_thermal(&snapshot.thermal_picture(&scene, aim)), self.cameras.thermal_intrinsics())
            }
        };
        let Some(EncodedPicture { files, readings }) = encoded else {
            return ActionEnd::Failed { reason: texts::PICTURE_NOT_ENCODED.to_owned() };
        };
        let camera = Some(self.camera_report(kind, aim, &intrinsics));
        succeeded(ActionReport { at: time(at), camera, readings, ..ActionReport::default() }, files)
    }

    fn camera_report(&self, kind: PictureKind, aim: &CameraAim, intrinsics: &Intrinsics) -> CameraReport {
        // The thermal camera does not zoom.
        let zoom = if kind == PictureKind::Photo { aim.zoom } else { 1.0 };
        CameraReport {
            aim: CameraAim { zoom, ..*aim },
            size_px: [intrinsics.width_px, intrinsics.height_px],
            focal_px: intrinsics.focal_px,
            centre_px: intrinsics.centre_px,
            base_from_camera: geometry::pose_from_isometry(&self.cameras.base_from_camera(aim)),
            target_m: None,
            line_of_sight: None,
        }
    }

    fn sample(
        &mut self,
        call: ActionCallId,
        instrument: Instrument,
        mut snapshot: InstrumentSnapshot,
        seconds: f64,
    ) {
        let surroundings = self.surroundings();
        if !self.measurements.contains_key(&call) {
            while self.measurements.len() >= CONFIG.max_kept {
                self.measurements.pop_first();
            }
        }
        let readings = self.measurements.entry(call).or_insert_with(|| match instrument {
            Instrument::Air => Readings::Air(Vec::new()),
            Instrument::Gamma => {
                let channels = surroundings.gamma().config().channels;
                Readings::Gamma { seconds: 0.0, counts: vec![0; channels] }
            }
        });
        match readings {
            Readings::Air(readings) => readings.push(snapshot.air(&surroundings)),
            Readings::Gamma { seconds: total, counts } => {
                *total += seconds;
                snapshot.count_gamma(&surroundings, seconds, counts);
            }
        }
    }

    fn end_of_gamma(&mut self, seconds: f64, counts: Vec<u32>, at: Stamp) -> ActionEnd {
        let channel_kev = self.surroundings().gamma().config().channel_kev;
        let spectrum = GammaSpectrum { live_time_s: seconds, first_kev: 0.0, channel_kev, counts };
        let events = spectrum.counts_between(0.0, f64::INFINITY) as f64;
        let rate = Reading {
            name: "count_rate".to_owned(),
            value: events / seconds,
            standard_deviation: Some(events.sqrt() / seconds),
            unit: "1/s".to_owned(),
        };
        // Plain data always becomes JSON.
        let bytes = serde_json::to_vec(&spectrum).unwrap_or_default();
        let file = ActionFile { name: SPECTRUM_NAME.to_owned(), media_type: JSON.to_owned(), bytes };
        succeeded(ActionReport { at: time(at), readings: vec![rate], ..ActionReport::default() }, vec![file])
    }
}

fn time(at: Stamp) -> ReportTime {
    ReportTime { robot_time: at, ..ReportTime::default() }
}

fn end_of_air(readings: &[AirReading], at: Stamp) -> ActionEnd {
    let reading = |name: &str, unit: &str, value: fn(&AirReading) -> f64| {
        let (value, standard_deviation) = mean(readings.iter().map(value));
        Reading { name: name.to_owned(), value, standard_deviation, unit: unit.to_owned() }
    };
    let readings = vec![
        reading("temperature", "°C", |air| air.celsius),
        reading("relative_humidity", "%", |air| air.humidity_percent),
    ];
    succeeded(ActionReport { at: time(at), readings, ..ActionReport::default() }, Vec::new())
}

/// Mean, and its standard deviation by the scatter of the values if there are several.
fn mean(values: impl Iterator<Item = f64> + Clone) -> (f64, Option<f64>) {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    let scatter = values.map(|value| (value - mean).powi(2)).sum::<f64>();
    (mean, (count > 1.0).then(|| (scatter / (count - 1.0) / count).sqrt()))
}

fn succeeded(report: ActionReport, files: Vec<ActionFile>) -> ActionEnd {
    // Plain data always becomes JSON.
    ActionEnd::Succeeded { report: serde_json::to_string(&report).unwrap_or_default(), files }
}
