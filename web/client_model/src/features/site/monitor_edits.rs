//! Edits of monitors as operators make them: each a step of undo. The built-in ones are shown with those of the site; the site replaces one by a monitor of its id.

use super::{SiteEdit, SiteFeature};
use crate::texts;
use missions::{BatteryConfig, CHARGE_SIGNAL, battery_monitors};
use site_model::{Monitor, MonitorCondition, MonitorId, MonitorResponse, Object, ObjectId};
use std::collections::BTreeSet;

/// What a new monitor begins with.
struct NewMonitorConfig {
    /// Charge below which no mission begins. Chosen: above the charge at which the built-in monitor interrupts (20 %), so that no mission begins that is interrupted soon.
    threshold: f64,
    /// Charge above which missions begin again. Chosen: about half an hour of walking more.
    release: f64,
}

const CONFIG: NewMonitorConfig = NewMonitorConfig { threshold: 0.3, release: 0.6 };

impl SiteFeature {
    /// All monitors that the robot watches: the built-in ones, as the site has them if it replaces them, then its own by name. With each, whether it is built in.
    pub fn monitors(&self) -> Vec<(Monitor, bool)> {
        let of_site = |id: MonitorId| self.site()?.monitors().find(|it| it.id == id).cloned();
        let built_in = battery_monitors(&BatteryConfig::default());
        let ids: BTreeSet<MonitorId> = built_in.iter().map(|monitor| monitor.id).collect();
        let mut monitors: Vec<_> =
            built_in.into_iter().map(|monitor| (of_site(monitor.id).unwrap_or(monitor), true)).collect();
        let own = self.site().into_iter().flat_map(|site| site.monitors());
        let mut own: Vec<_> = own.filter(|monitor| !ids.contains(&monitor.id)).cloned().collect();
        own.sort_by(|a, b| a.name.cmp(&b.name).then(a.id.cmp(&b.id)));
        monitors.extend(own.into_iter().map(|monitor| (monitor, false)));
        monitors
    }

    /// A new monitor of the charge that lets no mission begin.
    pub fn adding_monitor(&self) -> (MonitorId, SiteEdit) {
        let id = MonitorId(self.new_id(0));
        let monitors = self.monitors();
        let names: BTreeSet<&str> = monitors.iter().map(|(monitor, _)| monitor.name.as_str()).collect();
        let free = (1..).map(texts::monitor_name).find(|name| !names.contains(name.as_str()));
        let monitor = Monitor {
            id,
            name: free.unwrap_or_default(),
            signal: CHARGE_SIGNAL.to_owned(),
            condition: MonitorCondition::Below { threshold: CONFIG.threshold, release: CONFIG.release },
            hold: BatteryConfig::default().hold,
            response: MonitorResponse::BlockMissions,
            is_enabled: true,
        };
        (id, SiteEdit { put: vec![Object::Monitor(monitor)], removed: Vec::new() })
    }

    /// A monitor after a change; nothing if that leaves it as it is. A built-in one becomes an object of the site.
    pub fn changing_monitor(&self, id: MonitorId, change: impl FnOnce(&mut Monitor)) -> SiteEdit {
        let mut edit = SiteEdit::default();
        if let Some((monitor, _)) = self.monitors().into_iter().find(|(monitor, _)| monitor.id == id) {
            let mut changed = monitor.clone();
            change(&mut changed);
            if changed != monitor {
                edit.put.push(Object::Monitor(changed));
            }
        }
        edit
    }

    /// A site without this monitor. A built-in one then has its built-in values again. Nothing if the site does not have it.
    pub fn removing_monitor(&self, id: MonitorId) -> SiteEdit {
        let object = ObjectId::Monitor(id);
        let is_there = self.site().is_some_and(|site| site.get(object).is_some());
        SiteEdit { put: Vec::new(), removed: is_there.then_some(object).into_iter().collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::Robot;
    use crate::testing::TestClient;
    use crate::{ClientCommand, SiteEdit};
    use site_model::{MonitorCondition, MonitorResponse};

    #[test]
    fn built_in_monitors_are_shown_replaced_and_given_their_values_back() {
        let robot = Robot::default();
        let mut client = TestClient::with_site(&robot);
        let names = |client: &TestClient| -> Vec<(String, bool)> {
            let monitors = client.model.site.monitors();
            monitors.into_iter().map(|(monitor, is_built_in)| (monitor.name, is_built_in)).collect()
        };
        let built_in = [("Battery low".to_owned(), true), ("Battery reserve".to_owned(), true)];
        assert_eq!(names(&client), built_in);

        let low = client.model.site.monitors()[0].0.clone();
        let condition = MonitorCondition::Below { threshold: 0.25, release: 0.9 };
        let edit = client.model.site.changing_monitor(low.id, |monitor| monitor.condition = condition);
        client.command(ClientCommand::EditSite(edit));
        assert_eq!(client.model.site.monitors()[0].0.condition, condition);
        let same = client.model.site.changing_monitor(low.id, |monitor| monitor.condition = condition);
        assert_eq!(same, SiteEdit::default());
        let (own, edit) = client.model.site.adding_monitor();
        client.command(ClientCommand::EditSite(edit));
        let monitors = client.model.site.monitors();
        assert_eq!((monitors.len(), monitors[2].0.id, monitors[2].1), (3, own, false));
        assert_eq!(monitors[2].0.response, MonitorResponse::BlockMissions);

        client.command(ClientCommand::EditSite(client.model.site.removing_monitor(low.id)));
        assert_eq!(client.model.site.monitors()[0].0, low);
        assert_eq!(client.model.site.removing_monitor(low.id), SiteEdit::default());
        client.command(ClientCommand::Undo);
        assert_eq!(client.model.site.monitors()[0].0.condition, condition);
    }
}
