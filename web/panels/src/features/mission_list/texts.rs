//! Texts of the list of missions, by key.

use crate::format;

pub(super) const HEAD: &str = "Missions";
pub(super) const LOADING: &str = "The site has not arrived from the robot yet.";
pub(super) const NONE: &str = "There are no missions yet. A mission is a list of tasks: inspection points to look at, places to visit, actions to perform.";
pub(super) const NO_NODES: &str =
    "A mission needs places. Make the topological map on the Site screen first.";
pub(super) const TO_SITE: &str = "Go to the Site screen";
pub(super) const NOTHING: &str = "No mission has this name.";
pub(super) const SEARCH: &str = "Search missions";
pub(super) const SEARCH_HINT: &str = "Search";
pub(super) const NEW: &str = "New mission";
pub(super) const DUPLICATE_SHORT: &str = "Duplicate";
pub(super) const DELETE_SHORT: &str = "Delete";
pub(super) const KEEP: &str = "Keep";
pub(super) const KEEP_NAME: &str = "Keep the mission";
pub(super) const SAVE: &str = "Save to a file";
pub(super) const SAVE_SHORT: &str = "Save file";
pub(super) const LOAD: &str = "Load from a file";
pub(super) const LOAD_SHORT: &str = "Load file";
pub(super) const UNNAMED: &str = "Mission without a name";

pub(super) fn open(name: &str) -> String {
    format!("Mission {name}")
}

pub(super) fn duplicate(name: &str) -> String {
    format!("Duplicate {name}")
}

pub(super) fn delete(name: &str) -> String {
    format!("Delete {name}")
}

pub(super) fn delete_for_sure(name: &str, schedules: usize) -> String {
    match schedules {
        0 => format!("Delete {name} for sure"),
        _ => format!("Delete {name} with its schedules"),
    }
}

pub(super) fn tasks(count: usize) -> String {
    match count {
        0 => "No tasks yet".to_owned(),
        1 => "1 task".to_owned(),
        count => format!("{count} tasks"),
    }
}

/// Tasks, expected time, and the schedules that run it.
pub(super) fn summary(tasks_count: usize, time_s: Option<f64>, schedules: &[&str]) -> String {
    let mut parts = vec![tasks(tasks_count)];
    parts.extend(time_s.map(format::duration));
    match schedules {
        [] => {}
        [one] => parts.push(format!("schedule {one}")),
        several => parts.push(format!("{} schedules", several.len())),
    }
    parts.join(" · ")
}

pub(super) fn problems(count: usize) -> String {
    match count {
        1 => "1 task cannot be done".to_owned(),
        count => format!("{count} tasks cannot be done"),
    }
}

/// What a deletion takes along.
pub(super) fn deletion(name: &str, schedules: &[&str], monitors: &[&str]) -> String {
    let mut sentences = vec![format!("Delete {name}?")];
    if !schedules.is_empty() {
        sentences.push(format!("Its schedules go with it: {}.", schedules.join(", ")));
    }
    if !monitors.is_empty() {
        sentences.push(format!("These monitors then have nothing to run: {}.", monitors.join(", ")));
    }
    sentences.join(" ")
}
