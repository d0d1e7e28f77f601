//! Reads gauges in a separate process, so that a damaged or very large picture cannot harm the core.

use super::child_complaint::complaint;
use super::child_wait::wait;
use crate::gauge::{Document, Reading as Read};
use crate::limited_command::LimitedCommand;
use crate::process_limits::{WITHIN_LIMITS, limit_reached};
use crate::texts;
use gauge_file::description_of;
use ports::{GaugeReader, ReadGauge};
use site_model::{GAUGE_READING, GaugeDial, GaugeReport, Reading};
use std::io::{Read as _, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::Duration;

/// Limits of a reading on the robot.
struct GaugeProcessConfig {
    /// Most memory, MB. Chosen: pictures of 12 megapixels fit.
    max_memory_mb: u32,
    /// Most processor time, minutes. Chosen: 640 x 480 pixels take a tenth of a second, and time grows with the pixels.
    max_minutes: f64,
    /// Time between two questions whether it is done. Chosen: little beside the reading.
    poll_period: Duration,
}

const CONFIG: GaugeProcessConfig =
    GaugeProcessConfig { max_memory_mb: 1024, max_minutes: 1.0, poll_period: Duration::from_millis(10) };

/// Runs `autoinspect gauge`.
pub struct GaugeProcess;

impl GaugeReader for GaugeProcess {
    fn read(
        &self,
        picture: &Path,
        described_in: &Path,
        dial: &GaugeDial,
        is_cancelled: &mut dyn FnMut() -> bool,
    ) -> Result<ReadGauge, String> {
        let description = description_of(dial).map_err(|error| texts::gauge_not_understood(&error))?;
        let program = std::env::current_exe().map_err(|error| texts::import_not_started(&error))?;
        let mut command = Command::new(program);
        command.args(["gauge", WITHIN_LIMITS, "--json", "--gauge=-"]);
        command.arg(format!("--max-memory={}", CONFIG.max_memory_mb));
        command.arg(format!("--max-minutes={}", CONFIG.max_minutes));
        command.arg("--described-in").args([described_in, Path::new("--"), picture]);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().map_err(|error| texts::import_not_started(&error))?;
        if let Some(mut input) = child.stdin.take() {
            // A process that does not read it says why on its standard error.
            let _ = input.write_all(description.as_bytes());
        }
        let (output, errors) = (child.stdout.take(), child.stderr.take());
        thread::scope(|scope| {
            let complaint = scope.spawn(|| complaint(errors));
            let answer = scope.spawn(|| {
                let mut text = String::new();
                // What is missing at the end is no JSON.
                let _ = output.map(|mut output| output.read_to_string(&mut text));
                text
            });
            let status = wait(&mut child, CONFIG.poll_period, is_cancelled);
            let (complaint, answer) =
                (complaint.join().unwrap_or_default(), answer.join().unwrap_or_default());
            let status = status?;
            match limit_reached(status) {
                _ if status.success() => understood(&answer, dial),
                Some(limit) => Err(texts::limit_on_robot(LimitedCommand::Gauge, limit).to_owned()),
                None => Err(complaint),
            }
        })
    }
}

/// What the process has printed. Its sentences end without a full stop.
fn understood(answer: &str, dial: &GaugeDial) -> Result<ReadGauge, String> {
    let document: Document =
        serde_json::from_str(answer).map_err(|error| texts::gauge_not_understood(&error))?;
    let mut read = ReadGauge {
        reading: None,
        report: GaugeReport {
            alignment_residual_px: document.alignment_residual_px,
            ..GaugeReport::default()
        },
    };
    read.report.problem = match document.reading {
        Read::Read { value, uncertainty, axis_px, tip_px, .. } => {
            read.reading = Some(Reading {
                name: GAUGE_READING.to_owned(),
                value,
                standard_deviation: Some(uncertainty),
                unit: dial.unit.clone(),
            });
            read.report.needle_px = Some([axis_px, tip_px]);
            None
        }
        Read::Unsure { explanation, .. } => Some(texts::gauge_unsure(&explanation)),
        Read::TooSmall { radius_px, least_px } => Some(texts::gauge_too_small(radius_px, least_px)),
        Read::NotAligned { explanation } => Some(texts::gauge_not_aligned(&explanation)),
    };
    Ok(read)
}
