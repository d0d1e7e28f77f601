//! Runs imports in a separate process, so that broken or very large files cannot harm the core.

use super::child_complaint::complaint;
use crate::changes::Document;
use crate::limited_command::LimitedCommand;
use crate::process_limits::{WITHIN_LIMITS, limit_reached};
use crate::texts;
use api::ImportStage;
use ports::MapImporter;
use serde::Deserialize;
use site_model::SceneChange;
use std::ffi::OsString;
use std::fs;
use std::io::{BufRead, BufReader};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use vocab::Vec3;

/// Limits on the robot.
struct ImportProcessConfig {
    /// Most memory of a new version of a map, MB. Its scans are compared with both versions. Chosen: as a comparison of visits.
    make_normal_memory_mb: u32,
}

const CONFIG: ImportProcessConfig = ImportProcessConfig { make_normal_memory_mb: 1024 };

/// Runs `autoinspect import`, `align` and `make-normal`.
pub struct ImportProcess;

/// A line of progress that the import prints.
#[derive(Deserialize)]
struct Line {
    stage: ImportStage,
    share: f32,
}

impl MapImporter for ImportProcess {
    fn import(
        &self,
        file: &Path,
        name: &str,
        frame: Option<&Path>,
        out: &Path,
        progress: &mut dyn FnMut(ImportStage, f32) -> ControlFlow<()>,
    ) -> Result<(), String> {
        let mut arguments: Vec<OsString> =
            vec!["import".into(), WITHIN_LIMITS.into(), format!("--name={name}").into()];
        arguments.extend(["--out".into(), out.into()]);
        if let Some(frame) = frame {
            arguments.extend(["--align-to".into(), frame.into()]);
        }
        arguments.extend(["--background".into(), "--".into(), file.into()]);
        let named: Vec<_> = [(Some(file), texts::UPLOADED_FILE), (frame, texts::FRAME_OF_IMPORT)]
            .into_iter()
            .filter_map(|(path, name)| Some((path?, name)))
            .collect();
        run(Some(LimitedCommand::Import), &arguments, &named, progress)
    }

    fn align(
        &self,
        [map, onto]: [&Path; 2],
        pairs: &[[Vec3; 2]],
        name: &str,
        out: &Path,
        progress: &mut dyn FnMut(ImportStage, f32) -> ControlFlow<()>,
    ) -> Result<(), String> {
        let mut arguments: Vec<OsString> =
            vec!["align".into(), WITHIN_LIMITS.into(), format!("--name={name}").into()];
        arguments.extend(["--out".into(), out.into(), "--onto".into(), onto.into()]);
        arguments.extend(pairs.iter().map(|[from, to]| {
            let [from, to] = [from, to].map(|at| format!("{},{},{}", at.x, at.y, at.z));
            format!("--pair={from}={to}").into()
        }));
        arguments.extend(["--background".into(), "--".into(), map.into()]);
        let named = [(map, texts::ALIGNED_MAP), (onto, texts::OTHER_MAP)];
        run(Some(LimitedCommand::Align), &arguments, &named, progress)
    }

    fn make_normal(
        &self,
        map: &Path,
        after: &[PathBuf],
        changes: &[SceneChange],
        name: &str,
        out: &Path,
        progress: &mut dyn FnMut(ImportStage, f32) -> ControlFlow<()>,
    ) -> Result<(), String> {
        let file = out.with_extension("changes.json");
        let written = serde_json::to_vec(&Document::of_scene(changes))
            .map_err(std::io::Error::other)
            .and_then(|text| fs::write(&file, text));
        written.map_err(|error| texts::import_not_started(&error))?;
        let mut arguments: Vec<OsString> =
            vec!["make-normal".into(), WITHIN_LIMITS.into(), format!("--name={name}").into()];
        arguments.extend([format!("--max-memory={}", CONFIG.make_normal_memory_mb).into()]);
        arguments.extend(["--out".into(), out.into(), "--map".into(), map.into()]);
        arguments.extend(["--changes".into(), (&file).into(), "--background".into(), "--".into()]);
        arguments.extend(after.iter().map(Into::into));
        let named = [(map, texts::ALIGNED_MAP)];
        let made = run(Some(LimitedCommand::MakeNormal), &arguments, &named, progress);
        // A file that cannot be removed is small, and nothing reads it.
        let _ = fs::remove_file(&file);
        made
    }
}

/// Runs this program with other arguments until it ends or is cancelled. `command` says whose limits it has. Paths in its errors are replaced by the names given here.
pub(super) fn run(
    command: Option<LimitedCommand>,
    arguments: &[OsString],
    named: &[(&Path, &str)],
    progress: &mut dyn FnMut(ImportStage, f32) -> ControlFlow<()>,
) -> Result<(), String> {
    let started = std::env::current_exe().and_then(|program| {
        let mut import = Command::new(program);
        // Nothing is written to its standard input. That ends with this process, and the import then ends too.
        import.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()
    });
    let mut child = started.map_err(|error| texts::import_not_started(&error))?;
    let (lines, errors) = (child.stdout.take(), child.stderr.take());
    let (cancelled, complaint) = thread::scope(|scope| {
        // On another thread than progress, because a child would block if its standard error were full.
        let complaint = scope.spawn(|| complaint(errors));
        let cancelled = lines.is_some_and(|lines| follow(BufReader::new(lines), progress).is_break());
        if cancelled {
            // The child may have ended by itself in the meantime.
            let _ = child.kill();
        }
        (cancelled, complaint.join().unwrap_or_default())
    });
    match child.wait() {
        _ if cancelled => Err(texts::IMPORT_CANCELLED.to_owned()),
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(match (limit_reached(status), command) {
            (Some(limit), Some(command)) => texts::limit_on_robot(command, limit).to_owned(),
            (None, _) | (_, None) => named
                .iter()
                .fold(complaint, |text, (path, name)| text.replace(&path.display().to_string(), name)),
        }),
        Err(error) => Err(texts::import_outcome_unknown(&error)),
    }
}

/// Reads progress until the child ends or is cancelled.
fn follow(
    lines: impl BufRead,
    progress: &mut dyn FnMut(ImportStage, f32) -> ControlFlow<()>,
) -> ControlFlow<()> {
    for line in lines.lines().map_while(Result::ok) {
        if let Ok(Line { stage, share }) = serde_json::from_str(&line) {
            progress(stage, share)?;
        }
    }
    ControlFlow::Continue(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_is_read_line_by_line_until_it_is_cancelled() {
        let lines =
            b"{\"stage\":\"reading\",\"share\":0.5}\nnonsense\n{\"stage\":\"computing_viewpoints\",\"share\":0.25}\n"
                .as_slice();
        let mut heard = Vec::new();
        let all = follow(lines, &mut |stage, share| {
            heard.push((stage, share));
            ControlFlow::Continue(())
        });
        assert_eq!(heard, [(ImportStage::Reading, 0.5), (ImportStage::ComputingViewpoints, 0.25)]);
        assert!(all.is_continue() && follow(lines, &mut |_, _| ControlFlow::Break(())).is_break());
    }
}
