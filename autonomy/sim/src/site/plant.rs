//! `plant`: a process plant on two floors with a yard.

use super::Plan;

pub(super) fn plan() -> Plan {
    Plan::default()
}
