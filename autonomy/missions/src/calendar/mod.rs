//! Calendar time: zones, recurrence rules, and the slots of schedules. A pure function of its input: the zones are those of the program, not of the system.

mod civil;
mod recurrence_rule;
mod rule_expansion;
#[cfg(test)]
mod rule_tests;
mod site_zone;
mod slots;
#[cfg(test)]
mod zone_tests;

pub use civil::{MINUTES_A_DAY, date_of, day_number, local_of, minute_number, weekday_of};
pub use recurrence_rule::{RecurrenceRule, RuleError};
pub use site_zone::{ClockChange, SiteZone, ZoneError};
pub use slots::{Slot, Slots};
