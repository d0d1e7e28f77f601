//! Statistics of a reading over time that a few wrong values do not move: median, median absolute deviation, a trend by Theil and Sen, an
//! offset for each hour of the day, and the readings that do not fit.
//!
//! [`analyse`] is the way in. The crate knows no clock, no time zone and no unit: whoever calls it says at which hour of which day of the site
//! each reading was made. It has no dependencies, so that robot and browser compute the same.
//!
//! Files: `robust` has medians and deviations, `trend` the slope, `hours` the offsets by hour, `analysis` puts them together.

mod analysis;
mod hours;
mod robust;
mod trend;

pub use analysis::{Analysis, ReadingsConfig, Sample, analyse};
pub use robust::{median, median_absolute_deviation, robust_deviation};
pub use trend::{Trend, theil_sen_slope};
