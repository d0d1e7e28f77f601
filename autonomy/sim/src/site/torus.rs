//! `torus`: a hall round a fusion machine.

use super::Plan;

pub(super) fn plan() -> Plan {
    Plan::default()
}
