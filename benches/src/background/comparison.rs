//! A comparison by the program, and the time it takes.

use anyhow::{Context, Result, ensure};
use changes::UprightBox;
use rustix::process::{Pid, WaitId, WaitIdOptions, waitid};
use serde::Deserialize;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

/// Clock ticks for each second of processor time in `/proc`, on Linux always.
const TICKS_PER_S: f64 = 100.0;

/// What the program found, and how long that took.
pub struct Comparison {
    pub objects: Vec<Found>,
    /// On the clock, from the start of the process to its end.
    pub seconds: f64,
    /// Processor time of the process and its children.
    pub processor_s: f64,
}

/// An object that changed.
pub struct Found {
    /// Where it was; none of a new one.
    pub was: Option<UprightBox>,
    /// Where it is; none of one that is gone.
    pub is: Option<UprightBox>,
}

#[derive(Deserialize)]
struct Document {
    objects: Vec<Object>,
}

#[derive(Deserialize)]
struct Object {
    kind: Kind,
    #[serde(flatten)]
    place: Place,
    from: Option<Place>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    Appeared,
    Removed,
    Moved,
}

#[derive(Clone, Copy, Deserialize)]
struct Place {
    centre_m: [f64; 3],
    size_m: [f64; 3],
    yaw_rad: f64,
}

impl Place {
    fn upright_box(self) -> UprightBox {
        UprightBox { centre_m: self.centre_m.into(), size_m: self.size_m, yaw_rad: self.yaw_rad }
    }
}

/// Compares two folders of clouds, as the robot does.
///
/// # Errors
/// When the program cannot be started, or fails.
pub fn compare(program: &Path, before: &Path, after: &Path, out: &Path) -> Result<Comparison> {
    let begun = Instant::now();
    let mut child = Command::new(program)
        .args(["changes", "--background", "--max-memory=1024", "--out"])
        .arg(out)
        .args([before, after])
        // It ends when its standard input does.
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .with_context(|| format!("{} cannot be started; cargo xtask bench builds it", program.display()))?;
    let id = Pid::from_child(&child);
    // Its times are in `/proc` until it is waited for.
    waitid(WaitId::Pid(id), WaitIdOptions::EXITED | WaitIdOptions::NOWAIT)?;
    let seconds = begun.elapsed().as_secs_f64();
    let processor_s = processor_s(&fs::read_to_string(format!("/proc/{}/stat", child.id()))?)?;
    ensure!(child.wait()?.success(), "{} failed", program.display());
    let document: Document = serde_json::from_slice(&fs::read(out.join("changes.json"))?)?;
    let found = |object: &Object| {
        let place = object.place.upright_box();
        match object.kind {
            Kind::Appeared => Found { was: None, is: Some(place) },
            Kind::Removed => Found { was: Some(place), is: None },
            Kind::Moved => Found { was: object.from.map(Place::upright_box), is: Some(place) },
        }
    };
    Ok(Comparison { objects: document.objects.iter().map(found).collect(), seconds, processor_s })
}

/// Processor time of a process and its children by its line in `/proc` (proc(5): the fields 14 to 17).
fn processor_s(stat: &str) -> Result<f64> {
    let (_, fields) = stat.rsplit_once(')').context("no name in the state of a process")?;
    let ticks = fields.split_whitespace().skip(11).take(4).map(str::parse::<f64>);
    Ok(ticks.collect::<Result<Vec<_>, _>>()?.iter().sum::<f64>() / TICKS_PER_S)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_of_a_process_is_its_own_and_that_of_its_children() {
        let stat = "7 (a (b) c) S 1 7 7 0 -1 4194560 100 200 0 0 150 50 300 100 20 0 1 0 1 1 1";
        assert_eq!(processor_s(stat).expect("a line"), 6.0);
        assert!(processor_s("7").is_err());
    }
}
