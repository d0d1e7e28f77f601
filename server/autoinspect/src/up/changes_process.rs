//! Compares visits in a separate process, so that memory and time that this takes cannot harm the core.

use super::child_complaint::complaint;
use super::child_wait::wait;
use crate::changes::{CHANGED, Document, Kind, RESULT, UNCHANGED, object_file};
use crate::limited_command::LimitedCommand;
use crate::process_limits::{WITHIN_LIMITS, limit_reached};
use crate::texts;
use ports::{ChangeFinder, FoundChange, FoundChanges};
use site_model::{SceneChangeKind, ShapeDescriptor};
use std::fs;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::thread;
use std::time::Duration;

/// Limits of a comparison on the robot.
struct ComparisonConfig {
    /// Most memory, MB. Chosen: a robot's computer has 8 GB or more.
    max_memory_mb: u32,
    /// Time between two questions whether to give up. Chosen: nobody notices a tenth of a second.
    poll_period: Duration,
}

const CONFIG: ComparisonConfig =
    ComparisonConfig { max_memory_mb: 1024, poll_period: Duration::from_millis(100) };

/// Runs `autoinspect changes`.
pub struct ChangesProcess;

impl ChangeFinder for ChangesProcess {
    fn compare(
        &self,
        before: &Path,
        after: &Path,
        out: &Path,
        is_cancelled: &mut dyn FnMut() -> bool,
    ) -> Result<FoundChanges, String> {
        let program = std::env::current_exe().map_err(|error| texts::import_not_started(&error))?;
        let mut command = Command::new(program);
        command.args(["changes", WITHIN_LIMITS, "--background"]);
        command.arg(format!("--max-memory={}", CONFIG.max_memory_mb)).arg("--out").arg(out);
        command.arg("--").args([before, after]);
        // Nothing is written to its standard input. That ends with this process, and the comparison then ends too.
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = command.spawn().map_err(|error| texts::import_not_started(&error))?;
        let errors = child.stderr.take();
        let complaint = thread::scope(|scope| {
            let complaint = scope.spawn(|| complaint(errors));
            let status = wait(&mut child, CONFIG.poll_period, is_cancelled);
            let complaint = complaint.join().unwrap_or_default();
            outcome(status?, complaint)
        });
        complaint?;
        read(out)
    }
}

fn outcome(status: ExitStatus, complaint: String) -> Result<(), String> {
    match limit_reached(status) {
        _ if status.success() => Ok(()),
        Some(limit) => Err(texts::limit_on_robot(LimitedCommand::Changes, limit).to_owned()),
        None => Err(complaint),
    }
}

/// Reads what the comparison has written.
fn read(out: &Path) -> Result<FoundChanges, String> {
    let text = fs::read(out.join(RESULT)).map_err(|error| texts::comparison_not_read(&error))?;
    let document: Document =
        serde_json::from_slice(&text).map_err(|error| texts::comparison_not_read(&error))?;
    let objects = document.objects.into_iter().map(|object| FoundChange {
        kind: match (object.kind, object.from) {
            (Kind::Appeared, _) => SceneChangeKind::Appeared,
            (Kind::Moved, Some(from)) => SceneChangeKind::Moved { from: from.oriented_box() },
            (Kind::Removed | Kind::Moved, _) => SceneChangeKind::Removed,
        },
        place: object.place.oriented_box(),
        points: u32::try_from(object.points).unwrap_or(u32::MAX),
        confidence: object.confidence,
        cloud: object_file(out, object.id),
        move_probability: object.move_probability,
        descriptor: object.descriptor.map(|plain| ShapeDescriptor { name: plain.name, values: plain.values }),
    });
    Ok(FoundChanges {
        objects: objects.collect(),
        changed: out.join(CHANGED),
        unchanged: out.join(UNCHANGED),
    })
}
