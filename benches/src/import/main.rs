//! Reads maps of other programs: real files and large generated ones. Prints the time of each, or its error.

#![allow(clippy::print_stdout, reason = "the table is this program's output")]

use anyhow::{Context, Result};
use benches::thread_ms;
use clap::Parser;
use formats::{SurveyLimits, pcd, survey};
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Speed of reading maps of other programs.
///
/// Example: cargo xtask bench import --files ../shared/data/map-import
#[derive(Parser)]
struct Arguments {
    /// Folder of maps, `malformed/` included.
    #[arg(long, default_value = "../shared/data/map-import")]
    files: PathBuf,
    /// Points of the generated LAS, LAZ and binary PCD files.
    #[arg(long, default_value_t = 5_000_000)]
    points: usize,
    /// Folder for them.
    #[arg(long, default_value = "target/bench-import")]
    work: PathBuf,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let mut files = Vec::new();
    for folder in [arguments.files.clone(), arguments.files.join("malformed")] {
        let entries = fs::read_dir(&folder)
            .with_context(|| format!("{} cannot be listed; see --files", folder.display()))?;
        files.extend(entries.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>>>()?);
    }
    files.retain(|path| path.is_file());
    files.sort();
    println!(
        "{:<44} {:>6} {:>10} {:>8} {:>9} {:>11}",
        "file", "scans", "points", "left out", "ms", "million/s"
    );
    for path in &files {
        print_row(path);
    }
    fs::create_dir_all(&arguments.work)?;
    for path in generate(&arguments.work, arguments.points)? {
        print_row(&path);
        fs::remove_file(&path)?;
    }
    Ok(())
}

fn print_row(path: &Path) {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let began = thread_ms();
    let read = survey::read(path, SurveyLimits::NONE, &mut |_| {});
    let ms = thread_ms() - began;
    match read {
        Ok(survey) => {
            let (points, scans) = (survey.points(), survey.stations.len());
            let speed = (points + survey.unusable) as f64 / ms / 1e3;
            println!("{name:<44} {scans:>6} {points:>10} {:>8} {ms:>9.1} {speed:>11.2}", survey.unusable);
        }
        Err(error) => println!("{name:<44} {:>6} {:>10} {:>8} {ms:>9.1}   {error}", "-", "-", "-"),
    }
}

/// Writes an uneven floor of `points` points as LAS, LAZ and PCD.
fn generate(folder: &Path, points: usize) -> Result<Vec<PathBuf>> {
    let side = (points as f64).sqrt().ceil() as usize;
    let xyz: Vec<[f32; 3]> = (0..points)
        .map(|index| {
            let (i, j) = ((index / side) as f32, (index % side) as f32);
            [i * 0.02, j * 0.02, 0.05 * (i * 0.01).sin() * (j * 0.013).cos()]
        })
        .collect();
    let intensity: Vec<f32> = (0..points).map(|index| (index % 200) as f32).collect();
    let paths = ["generated.las", "generated.laz", "generated.pcd"].map(|name| folder.join(name));
    for (path, compressed) in paths.iter().zip([false, true]) {
        formats::las::write(BufWriter::new(File::create(path)?), &xyz, &intensity, compressed)?;
    }
    let mut file = BufWriter::new(File::create(&paths[2])?);
    pcd::write(&mut file, [0.0; 3], &xyz, &intensity)?;
    file.flush()?;
    Ok(paths.to_vec())
}
