//! Trajectories in the TUM format: one pose a line, `seconds x y z qx qy qz qw`.

use crate::{FormatError, texts};
use std::io::{self, Write};
use vocab::{Pose, Quat, Stamp, Vec3};

/// Reads a trajectory. Numbers are separated by blanks or commas; lines that begin with `#` are comments.
///
/// # Errors
/// When a line does not hold eight numbers.
pub fn read(text: &str) -> Result<Vec<(Stamp, Pose)>, FormatError> {
    let is_data = |line: &str| !line.is_empty() && !line.starts_with('#');
    let lines = text.lines().map(str::trim).enumerate().filter(|(_, line)| is_data(line));
    lines.map(|(index, line)| read_line(line, index + 1)).collect()
}

fn read_line(line: &str, number: usize) -> Result<(Stamp, Pose), FormatError> {
    const WHAT: &str = "TUM trajectory";
    let words: Vec<&str> = line.split([' ', '\t', ',']).filter(|word| !word.is_empty()).collect();
    let [time, numbers @ ..] = words.as_slice() else {
        return Err(FormatError::at_line(WHAT, number, texts::TRAJECTORY_LINE_EMPTY));
    };
    let stamp = stamp(time).ok_or_else(|| FormatError::at_line(WHAT, number, texts::not_a_time(time)))?;
    let values: Option<Vec<f64>> = numbers.iter().map(|word| word.parse().ok()).collect();
    let Some(&[x, y, z, qx, qy, qz, qw, ..]) = values.as_deref() else {
        return Err(FormatError::at_line(WHAT, number, texts::TRAJECTORY_LINE_SHORT));
    };
    Ok((stamp, Pose { position: Vec3::new(x, y, z), orientation: Quat { w: qw, x: qx, y: qy, z: qz } }))
}

/// Seconds in decimal digits, exact to the nanosecond if the text is.
pub fn stamp(text: &str) -> Option<Stamp> {
    let plain = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    let (whole, fraction) = text.split_once('.').unwrap_or((text, "0"));
    if plain(whole) && plain(fraction) && whole.len() <= 10 {
        let nanos: String = fraction.chars().chain("000000000".chars()).take(9).collect();
        return Some(Stamp::from_parts(whole.parse().ok()?, nanos.parse().ok()?));
    }
    text.parse::<f64>().ok().filter(|seconds| seconds.is_finite()).map(Stamp::from_secs_f64)
}

/// Writes a trajectory, stamps exact to the nanosecond.
///
/// # Errors
/// When `out` fails.
pub fn write<'a>(out: &mut impl Write, poses: impl IntoIterator<Item = &'a (Stamp, Pose)>) -> io::Result<()> {
    for (stamp, Pose { position: p, orientation: q }) in poses {
        let sign = if stamp.nanos() < 0 { "-" } else { "" };
        let nanos = stamp.nanos().unsigned_abs();
        let (secs, nanos) = (nanos / 1_000_000_000, nanos % 1_000_000_000);
        writeln!(
            out,
            "{sign}{secs}.{nanos:09} {:.6} {:.6} {:.6} {:.9} {:.9} {:.9} {:.9}",
            p.x, p.y, p.z, q.x, q.y, q.z, q.w
        )?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_with_exact_stamps() {
        let pose = Pose {
            position: Vec3::new(1.5, -2.0, 0.25),
            orientation: Quat { w: 0.5, x: 0.5, y: -0.5, z: 0.5 },
        };
        let poses = vec![(Stamp::from_nanos(1_700_000_000_123_456_789), pose), (Stamp::from_nanos(-5), pose)];
        let mut text = Vec::new();
        write(&mut text, &poses).unwrap();
        assert_eq!(read(std::str::from_utf8(&text).unwrap()).unwrap(), poses);
    }

    #[test]
    fn comments_commas_and_bad_lines() {
        assert_eq!(read("# t x\n1.5,0,0,0,0,0,0,1\n\n").unwrap()[0].0, Stamp::from_nanos(1_500_000_000));
        let error = read("1 0 0 0 0 0 0 1\n2 0 0 x 0 0 0 1\n").unwrap_err().to_string();
        assert!(error.contains("line 2"), "{error}");
        assert!(read("1 2 3").is_err());
        assert!(read("nan 0 0 0 0 0 0 1").is_err());
    }
}
