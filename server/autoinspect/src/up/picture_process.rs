//! Compares pictures in a separate process of low priority, so that damaged or very large pictures, and the time that a comparison takes, cannot harm the core.

use super::child_complaint::complaint;
use super::child_wait::wait;
use crate::limited_command::LimitedCommand;
use crate::picture_changes::Document;
use crate::process_limits::{WITHIN_LIMITS, limit_reached};
use crate::texts;
use ::picture_changes::{Homography, PosedCamera};
use geometry::{Vector3, isometry_from_pose};
use ports::{ComparedPicture, PictureComparer};
use site_model::{ActionReport, PictureComparisonOutcome};
use std::io::Read as _;
use std::process::{Command, Stdio};
use std::thread;
use std::time::Duration;

/// Limits of a comparison on the robot.
struct PictureProcessConfig {
    /// Most memory, MB. Chosen: pictures of 12 megapixels fit.
    max_memory_mb: u32,
    /// Most processor time, minutes. Chosen: 640 x 480 pixels take half a second (docs/benchmarks/picture-changes.md), and time grows with the pixels.
    max_minutes: f64,
    /// Time between two questions whether it is done. Chosen: little beside the comparison.
    poll_period: Duration,
}

const CONFIG: PictureProcessConfig =
    PictureProcessConfig { max_memory_mb: 1536, max_minutes: 2.0, poll_period: Duration::from_millis(20) };

/// Runs `autoinspect picture-changes`.
pub struct PictureProcess;

impl PictureComparer for PictureProcess {
    fn compare(
        &self,
        before: ComparedPicture<'_>,
        after: ComparedPicture<'_>,
        is_cancelled: &mut dyn FnMut() -> bool,
    ) -> Result<PictureComparisonOutcome, String> {
        let program = std::env::current_exe().map_err(|error| texts::import_not_started(&error))?;
        let mut command = Command::new(program);
        command.args(["picture-changes", WITHIN_LIMITS, "--background", "--json"]);
        command.arg(format!("--max-memory={}", CONFIG.max_memory_mb));
        command.arg(format!("--max-minutes={}", CONFIG.max_minutes));
        if let Some(predicted) = predicted(before.report, after.report) {
            let rows = predicted.matrix().transpose();
            let numbers: Vec<String> = rows.iter().map(f64::to_string).collect();
            command.arg(format!("--predicted={}", numbers.join(",")));
        }
        command.arg("--").args([before.file, after.file]);
        // Nothing is written to its standard input. That ends with this process, and the comparison then ends too.
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().map_err(|error| texts::import_not_started(&error))?;
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
                _ if status.success() => serde_json::from_str::<Document>(&answer)
                    .map(Document::outcome)
                    .map_err(|error| texts::comparison_not_understood(&error)),
                Some(limit) => Err(texts::limit_on_robot(LimitedCommand::PictureChanges, limit).to_owned()),
                None => Err(complaint),
            }
        })
    }
}

/// The mapping that the poses of both cameras predict for the plane through what the earlier one was aimed at. None if a pose, a camera or the target is not known, or
/// the poses are those of different maps.
fn predicted(before: &ActionReport, after: &ActionReport) -> Option<Homography> {
    let maps = [before, after].map(|report| report.place.and_then(|place| place.map));
    if maps[0].is_none() || maps[0] != maps[1] {
        return None;
    }
    let target_m = before.camera?.target_m?;
    let [before, after] = [posed_camera(before)?, posed_camera(after)?];
    let ahead = Vector3::new(target_m.x, target_m.y, target_m.z) - before.map_from_camera.translation.vector;
    let target = before.map_from_camera.rotation.inverse() * ahead;
    Homography::predicted(&before, &after, target.z)
}

fn posed_camera(report: &ActionReport) -> Option<PosedCamera> {
    let (place, camera) = (report.place?, report.camera?);
    Some(PosedCamera {
        focal_px: camera.focal_px,
        // The report counts from the outer corner of the first pixel, and the mapping from its middle.
        centre_px: camera.centre_px.map(|px| px - 0.5),
        map_from_camera: isometry_from_pose(&place.map_from_base)?
            * isometry_from_pose(&camera.base_from_camera)?,
    })
}
