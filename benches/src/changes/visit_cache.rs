//! Clouds of walks on the disk, so that a comparison can be repeated without its walks.

use anyhow::{Context, Result, ensure};
use changes::{SensorView, Visit};
use geometry::Vector3;
use std::fs;
use std::path::Path;

/// Writes a visit: for each view the place of the sensor, the number of points, and the points, as little-endian numbers.
pub fn write(path: &Path, visit: &Visit) -> Result<()> {
    let mut bytes = Vec::with_capacity(12 * visit.len() + 32 * visit.views.len());
    for view in &visit.views {
        bytes.extend(view.sensor.iter().flat_map(|at| at.to_le_bytes()));
        bytes.extend((view.points.len() as u64).to_le_bytes());
        bytes.extend(view.points.iter().flatten().flat_map(|at| at.to_le_bytes()));
    }
    fs::write(path, bytes).with_context(|| format!("could not write {}", path.display()))
}

/// Reads a visit; none if there is none.
pub fn read(path: &Path) -> Result<Option<Visit>> {
    if !path.exists() {
        return Ok(None);
    }
    let bytes = fs::read(path).with_context(|| format!("could not read {}", path.display()))?;
    let mut rest = bytes.as_slice();
    let mut visit = Visit::default();
    while !rest.is_empty() {
        let sensor = Vector3::new(number(&mut rest)?, number(&mut rest)?, number(&mut rest)?);
        let count = u64::from_le_bytes(take(&mut rest)?);
        let points = (0..count).map(|_| {
            let mut coordinate = || take(&mut rest).map(f32::from_le_bytes);
            Ok([coordinate()?, coordinate()?, coordinate()?])
        });
        visit.views.push(SensorView { sensor, points: points.collect::<Result<_>>()? });
    }
    Ok(Some(visit))
}

fn number(rest: &mut &[u8]) -> Result<f64> {
    take(rest).map(f64::from_le_bytes)
}

fn take<const N: usize>(rest: &mut &[u8]) -> Result<[u8; N]> {
    ensure!(rest.len() >= N, "the file of a visit is cut short; delete it");
    let (first, others) = rest.split_at(N);
    *rest = others;
    Ok(first.try_into()?)
}
