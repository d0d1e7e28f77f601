//! A run as one MCAP file for Foxglove and other programs of the field: poses, pictures, readings and spectra at their times, all other files beside them.

use super::mcap_schemas::{ALERT, COMPRESSED_IMAGE, POSE_IN_FRAME, READING, RESULT, SPECTRUM};
use super::names::{file_name, place_name, run_file_name};
use super::stored_content::{CoreQueries, action_report, for_each_result, stored_json};
use crate::blobs::blob_path;
use crate::site::document;
use crate::texts;
use api::{SiteState, StoredResult, StoredRun};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use recorder::JsonMcapWriter;
use serde_json::{Value, json};
use site_model::{ActionReport, GammaSpectrum, Object, ReportFile};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use vocab::{Pose, Vec3};

/// Longest picture or spectrum that becomes a message, bytes; longer ones are files beside the messages. Chosen: the longest photo of inspection cameras, and memory holds it three times.
const MAX_MESSAGE_BYTES: u64 = 16 << 20;
/// Name of the file of a gamma spectrum.
const SPECTRUM_FILE: &str = "spectrum.json";

/// A run that is written as MCAP.
pub(super) struct McapExport {
    run: StoredRun,
    site: Option<Arc<SiteState>>,
    data_dir: PathBuf,
}

impl McapExport {
    /// Names of places and of the mission are those of `site`.
    pub(super) fn new(run: StoredRun, site: Option<Arc<SiteState>>, data_dir: &Path) -> Self {
        Self { run, site, data_dir: data_dir.to_owned() }
    }

    /// Name of the file without its ending: ASCII letters, digits, `-` and `_`.
    pub(super) fn name(&self) -> String {
        run_file_name(&self.run, self.site.as_ref().map(|state| &state.site))
    }

    /// Writes the file. Memory holds a page of results, one picture, and a chunk of the file.
    ///
    /// # Errors
    /// When the core, the disk or whoever reads the file fails.
    pub(super) fn write(&self, core: &dyn CoreQueries, sink: impl Write) -> io::Result<()> {
        let mut mcap = JsonMcapWriter::new(sink)?;
        let mut missing = Vec::new();
        for_each_result(core, self.run.run, |result| self.write_result(&mut mcap, &result, &mut missing))?;
        self.write_alerts(&mut mcap)?;
        let mut about = BTreeMap::from([
            ("run".to_owned(), self.run.run.to_string()),
            ("mission".to_owned(), self.run.mission.to_string()),
            ("state".to_owned(), self.run.state.clone()),
        ]);
        if !missing.is_empty() {
            about.insert("missing_files".to_owned(), missing.join("\n"));
        }
        mcap.metadata("autoinspect_run", about)?;
        mcap.finish()
    }

    fn write_result<W: Write>(
        &self,
        mcap: &mut JsonMcapWriter<W>,
        result: &StoredResult,
        missing: &mut Vec<String>,
    ) -> io::Result<()> {
        let details = stored_json(&result.body);
        let place = self.place(&details);
        let topic = file_name(&place);
        let report = action_report(&details);
        let utc_ns = report.as_ref().map(|report| report.at.utc_ns).filter(|at| *at > 0);
        let utc_ns = utc_ns.unwrap_or(result.at.nanos());
        let whole = json!({
            "timestamp": timestamp(utc_ns), "number": result.number, "step": result.step, "attempt": result.attempt,
            "action": result.kind, "place": place, "details": details,
        });
        mcap.message("/results", RESULT, utc_ns, whole.to_string().as_bytes())?;
        let Some(report) = report else { return Ok(()) };
        if let Some(at) = &report.place {
            let frame = if at.map.is_some() { "map" } else { "odom" };
            let pose =
                json!({ "timestamp": timestamp(utc_ns), "frame_id": frame, "pose": pose(&at.map_from_base) });
            mcap.message("/pose", POSE_IN_FRAME, utc_ns, pose.to_string().as_bytes())?;
        }
        for reading in &report.readings {
            let message = json!({
                "timestamp": timestamp(utc_ns), "place": place, "name": reading.name, "value": reading.value,
                "standard_deviation": reading.standard_deviation, "unit": reading.unit,
            });
            let topic = format!("/readings/{topic}/{}", file_name(&reading.name));
            mcap.message(&topic, READING, utc_ns, message.to_string().as_bytes())?;
        }
        for file in &report.files {
            if !self.write_file(mcap, &report, file, utc_ns, (&place, &topic))? {
                missing.push(format!("{} {}", file.name, file.blob));
            }
        }
        Ok(())
    }

    /// Writes a file of a result: a picture or spectrum as a message, another one beside them. Returns whether it is on the disk.
    fn write_file<W: Write>(
        &self,
        mcap: &mut JsonMcapWriter<W>,
        report: &ActionReport,
        file: &ReportFile,
        utc_ns: i64,
        (place, topic): (&str, &str),
    ) -> io::Result<bool> {
        let path = blob_path(&self.data_dir, &file.blob.to_string());
        let Ok(content) = File::open(&path) else { return Ok(false) };
        let length = content.metadata()?.len();
        let name = file_name(file.name.rsplit_once('.').map_or(&*file.name, |(stem, _)| stem));
        if length <= MAX_MESSAGE_BYTES {
            if let Some(format) = picture_format(&file.media_type) {
                let frame = if report.camera.is_some() { "camera" } else { "base" };
                let (data, at) = (STANDARD.encode(fs::read(&path)?), timestamp(utc_ns));
                // As text, so that no second copy of the picture is made.
                let message = format!(
                    r#"{{"timestamp":{at},"frame_id":"{frame}","format":"{format}","data":"{data}"}}"#
                );
                let topic = format!("/pictures/{topic}/{name}");
                mcap.message(&topic, COMPRESSED_IMAGE, utc_ns, message.as_bytes())?;
                return Ok(true);
            }
            if file.name == SPECTRUM_FILE
                && let Ok(spectrum) = serde_json::from_slice::<GammaSpectrum>(&fs::read(&path)?)
            {
                let message = json!({ "timestamp": timestamp(utc_ns), "place": place, "spectrum": spectrum });
                let topic = format!("/spectra/{topic}");
                mcap.message(&topic, SPECTRUM, utc_ns, message.to_string().as_bytes())?;
                return Ok(true);
            }
        }
        let name = format!("{topic}/{}", file_name(&file.name));
        mcap.attachment(&name, &file.media_type, utc_ns, length, content)?;
        Ok(true)
    }

    /// Writes the alerts that the run has raised last, as they are now.
    fn write_alerts<W: Write>(&self, mcap: &mut JsonMcapWriter<W>) -> io::Result<()> {
        let Some(state) = &self.site else { return Ok(()) };
        for alert in state.site.alerts().filter(|alert| alert.cause.run() == Some(self.run.run)) {
            let utc_ns = alert.last_raised.0;
            let message = json!({
                "timestamp": timestamp(utc_ns), "severity": alert.severity, "alert": document(&Object::Alert(alert.clone())),
            });
            mcap.message("/alerts", ALERT, utc_ns, message.to_string().as_bytes())?;
        }
        Ok(())
    }

    /// Name of the place of a result: its inspection point, or else its node.
    fn place(&self, details: &Value) -> String {
        let name = self.site.as_ref().and_then(|state| place_name(&state.site, details));
        name.unwrap_or(texts::UNNAMED_PLACE).to_owned()
    }
}

/// The format of a picture, as `foxglove.CompressedImage` names it.
fn picture_format(media_type: &str) -> Option<&'static str> {
    match media_type {
        "image/jpeg" => Some("jpeg"),
        "image/png" => Some("png"),
        "image/webp" => Some("webp"),
        _ => None,
    }
}

fn timestamp(utc_ns: i64) -> Value {
    const SECOND_NS: i64 = 1_000_000_000;
    let utc_ns = utc_ns.max(0);
    json!({ "sec": utc_ns / SECOND_NS, "nsec": utc_ns % SECOND_NS })
}

fn pose(pose: &Pose) -> Value {
    let (Vec3 { x, y, z }, q) = (pose.position, pose.orientation);
    json!({ "position": { "x": x, "y": y, "z": z }, "orientation": { "x": q.x, "y": q.y, "z": q.z, "w": q.w } })
}

#[cfg(test)]
#[path = "mcap_tests.rs"]
mod tests;
