//! A cloud of rows and columns: PCD and PLY.

use super::coordinate_offset::CoordinateOffset;
use super::point_collector::PointCollector;
use super::station::{Station, Survey};
use crate::{FormatError, PointTable, SurveyLimits};

/// Turns a table into a survey without stations.
///
/// # Errors
/// When x, y or z is missing, or there are more points than the limit.
pub(super) fn read(table: &PointTable<'_>, limits: SurveyLimits) -> Result<Survey, FormatError> {
    let mut coordinate_offset = CoordinateOffset::default();
    let mut collector = PointCollector::new(&mut coordinate_offset, limits, 0);
    collector.reserve(table.len() as u64);
    for (point, intensity) in table.coordinates()?.zip(table.intensities()) {
        collector.add(point, intensity)?;
    }
    let (xyz, intensity, unusable) = collector.finish();
    let station = Station { name: None, survey_from_station: None, xyz, intensity };
    Ok(Survey { offset: coordinate_offset.offset(), stations: vec![station], unusable })
}
