//! Ids that follow from other ids, so that the same input has the same ids and nothing is random.

use site_model::{LocalDateTime, MonitorId, RunId, ScheduleId};
use uuid::Uuid;
use vocab::{ActionCallId, GoalId, LegId, Stamp};

/// Hash of some words: FNV-1a with 128 bits, marked as a UUID of version 8.
fn derive(kind: &str, words: &[u128]) -> Uuid {
    let mut hash: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    let words = words.iter().flat_map(|word| word.to_be_bytes());
    for byte in kind.bytes().chain(words) {
        hash = (hash ^ u128::from(byte)).wrapping_mul(0x0000_0000_0100_0000_0000_0000_0000_013b);
    }
    uuid::Builder::from_custom_bytes(hash.to_be_bytes()).into_uuid()
}

/// The goal that the event of this number of a run requests.
pub(crate) fn goal_id(run: RunId, step: u64) -> GoalId {
    GoalId(derive("goal", &[run.0.as_u128(), u128::from(step)]))
}

/// The call that the event of this number of a run makes.
pub(crate) fn call_id(run: RunId, step: u64) -> ActionCallId {
    ActionCallId(derive("call", &[run.0.as_u128(), u128::from(step)]))
}

/// The goal of a monitor that sends the robot to a dock, by the number of its event.
pub(crate) fn monitor_docking_goal_id(number: u64) -> GoalId {
    GoalId(derive("errand", &[u128::from(number)]))
}

/// The leg of this number of a goal on the topological map.
pub(crate) fn leg_id(goal: GoalId, number: u64) -> LegId {
    LegId(derive("leg", &[goal.0.as_u128(), u128::from(number)]))
}

/// The call of this number that a goal on the topological map makes.
pub(crate) fn edge_call_id(goal: GoalId, number: u64) -> ActionCallId {
    ActionCallId(derive("edge call", &[goal.0.as_u128(), u128::from(number)]))
}

/// The turn of the body of this number for a call.
pub fn turn_leg_id(call: ActionCallId, number: u32) -> LegId {
    LegId(derive("turn", &[call.0.as_u128(), u128::from(number)]))
}

/// The run of a slot.
pub(crate) fn slot_run_id(schedule: ScheduleId, slot: LocalDateTime) -> RunId {
    let minute = crate::calendar::minute_number(slot);
    RunId(derive("slot", &[schedule.0.as_u128(), minute as u128]))
}

/// The run by which a monitor interrupts. `number` tells runs of one instant apart.
pub(crate) fn monitor_run_id(monitor: MonitorId, at: Stamp, number: u128) -> RunId {
    RunId(derive("monitor", &[monitor.0.as_u128(), at.nanos() as u128, number]))
}
