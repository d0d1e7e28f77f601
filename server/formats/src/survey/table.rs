//! A cloud of rows and columns: PCD and PLY.

use super::coordinate_offset::CoordinateOffset;
use super::point_collector::PointCollector;
use super::station::{Station, Survey};
use crate::{FormatError, PointTable};

/// Turns a table into a survey without stations.
///
/// # Errors
/// When x, y or z is missing.
pub(super) fn read(table: &PointTable<'_>) -> Result<Survey, FormatError> {
    let [x, y, z] = table.coordinates()?;
    let intensity = table.intensity();
    let mut coordinate_offset = CoordinateOffset::default();
    let mut collector = PointCollector::new(&mut coordinate_offset);
    let intensities = intensity.into_iter().chain(std::iter::repeat(0.0));
    for (((x, y), z), intensity) in x.into_iter().zip(y).zip(z).zip(intensities) {
        collector.add([x, y, z], intensity);
    }
    let (xyz, intensity, unusable) = collector.finish();
    let station = Station { name: None, survey_from_station: None, xyz, intensity };
    Ok(Survey { offset: coordinate_offset.offset(), stations: vec![station], unusable })
}
