//! Edits of missions as operators make them: each a step of undo.

use crate::features::site::{SiteEdit, SiteFeature};
use site_model::{Mission, MissionId, MonitorResponse, Object, ObjectId, Site, Task, TaskId};
use std::collections::{BTreeMap, BTreeSet};

/// Name of a mission that nobody has named, before its number.
const MISSION_NAME: &str = "Mission";
/// Ends the name of a copy.
const COPY: &str = "copy";

impl SiteFeature {
    /// A new mission without tasks.
    pub fn adding_mission(&self) -> (MissionId, SiteEdit) {
        let id = MissionId(self.new_id(0));
        let mut edit = SiteEdit::default();
        if let Some(site) = self.site() {
            let count = site.missions().count();
            let name = free_name(site, |number| format!("{MISSION_NAME} {}", count + number));
            let (order, end) = Default::default();
            let mission = Mission { id, name, tasks: Vec::new(), order, order_constraints: Vec::new(), end };
            edit.put.push(Object::Mission(mission));
        }
        (id, edit)
    }

    /// A copy of a mission under another name. `None` if there is no such mission.
    pub fn duplicating_mission(&self, mission: MissionId) -> Option<(MissionId, SiteEdit)> {
        let site = self.site()?;
        let original = site.mission(mission)?;
        let id = MissionId(self.new_id(0));
        let name = free_name(site, |number| match number {
            1 => format!("{} {COPY}", original.name),
            _ => format!("{} {COPY} {number}", original.name),
        });
        let mut copy = Mission { id, name, ..original.clone() };
        let ids: BTreeMap<TaskId, TaskId> =
            (1..).zip(&copy.tasks).map(|(number, task)| (task.id, TaskId(self.new_id(number)))).collect();
        let renamed = |task: &TaskId| ids.get(task).copied().unwrap_or(*task);
        copy.tasks.iter_mut().for_each(|task| task.id = renamed(&task.id));
        copy.order_constraints.iter_mut().flatten().for_each(|task| *task = renamed(task));
        Some((id, SiteEdit { put: vec![Object::Mission(copy)], removed: Vec::new() }))
    }

    /// The removal of a mission and of the schedules that run it.
    pub fn removing_mission(&self, mission: MissionId) -> SiteEdit {
        let mut removed = vec![ObjectId::Mission(mission)];
        if let Some(site) = self.site() {
            let of_mission = site.schedules().filter(|schedule| schedule.mission == mission);
            removed.extend(of_mission.map(|schedule| ObjectId::Schedule(schedule.id)));
        }
        SiteEdit { put: Vec::new(), removed }
    }

    /// A mission after a change. Nothing if it leaves the mission as it is.
    pub fn changing_mission(&self, mission: MissionId, change: impl FnOnce(&mut Mission)) -> SiteEdit {
        let mut edit = SiteEdit::default();
        if let Some(before) = self.site().and_then(|site| site.mission(mission)) {
            let mut after = before.clone();
            change(&mut after);
            if after != *before {
                edit.put.push(Object::Mission(after));
            }
        }
        edit
    }

    /// A task of a mission after a change.
    pub fn changing_task(
        &self,
        mission: MissionId,
        task: TaskId,
        change: impl FnOnce(&mut Task),
    ) -> SiteEdit {
        self.changing_mission(mission, |mission| {
            if let Some(task) = mission.tasks.iter_mut().find(|it| it.id == task) {
                change(task);
            }
        })
    }

    /// Copies of tasks behind the last of them, and the ids of the copies.
    pub fn duplicating_tasks(
        &self,
        mission: MissionId,
        tasks: &BTreeSet<TaskId>,
    ) -> (BTreeSet<TaskId>, SiteEdit) {
        let mut copies = BTreeSet::new();
        let edit = self.changing_mission(mission, |mission| {
            let Some(last) = mission.tasks.iter().rposition(|task| tasks.contains(&task.id)) else { return };
            let originals = mission.tasks.iter().filter(|task| tasks.contains(&task.id));
            let copied: Vec<Task> = (0..)
                .zip(originals)
                .map(|(number, task)| Task { id: TaskId(self.new_id(number)), ..task.clone() })
                .collect();
            copies = copied.iter().map(|task| task.id).collect();
            mission.tasks.splice(last + 1..last + 1, copied);
        });
        (copies, edit)
    }

    /// A mission without these tasks, and without the order constraints that name them.
    pub fn deleting_tasks(&self, mission: MissionId, tasks: &BTreeSet<TaskId>) -> SiteEdit {
        self.changing_mission(mission, |mission| {
            mission.tasks.retain(|task| !tasks.contains(&task.id));
            mission.order_constraints.retain(|pair| !pair.iter().any(|task| tasks.contains(task)));
        })
    }
}

/// Names of the schedules that run a mission, and of the monitors that interrupt with it.
pub fn users_of_mission(site: &Site, mission: MissionId) -> (Vec<&str>, Vec<&str>) {
    let schedules = site.schedules().filter(|schedule| schedule.mission == mission);
    let interrupts = |response: &MonitorResponse| matches!(response, MonitorResponse::Interrupt { mission: it, .. } if *it == mission);
    let monitors = site.monitors().filter(|monitor| interrupts(&monitor.response));
    (
        schedules.map(|schedule| schedule.name.as_str()).collect(),
        monitors.map(|monitor| monitor.name.as_str()).collect(),
    )
}

/// The first of the names for the numbers from 1 on that no mission has.
fn free_name(site: &Site, name_of: impl Fn(usize) -> String) -> String {
    let names: BTreeSet<&str> = site.missions().map(|mission| mission.name.as_str()).collect();
    let mut number = 1;
    loop {
        let name = name_of(number);
        if !names.contains(name.as_str()) {
            return name;
        }
        number += 1;
    }
}
