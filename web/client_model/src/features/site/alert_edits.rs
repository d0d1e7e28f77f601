//! Edits of alerts as operators make them: each a step of undo.

use super::{SiteEdit, SiteFeature};
use site_model::{
    Alert, AlertCause, AlertId, AlertSeverity, AlertState, InspectionPointId, Object, ReviewState,
    SceneChange, TaskPlace, Utc,
};
use std::cmp::Reverse;
use vocab::Vec3;

impl SiteFeature {
    /// All alerts: the worst first, and then those that were raised last.
    pub fn alerts(&self) -> Vec<&Alert> {
        let mut alerts: Vec<&Alert> = self.site().into_iter().flat_map(|site| site.alerts()).collect();
        alerts.sort_by_key(|alert| (Reverse(alert.severity), Reverse(alert.last_raised), alert.id));
        alerts
    }

    /// Changes of the scene and alerts that nobody has looked at yet.
    pub fn unseen_findings(&self) -> usize {
        let changes = self.site().into_iter().flat_map(|site| site.scene_changes());
        let alerts = self.site().into_iter().flat_map(|site| site.alerts());
        changes.filter(|change| change.review == ReviewState::New).count()
            + alerts.filter(|alert| alert.state == AlertState::Open).count()
    }

    /// The inspection point of an alert or of its task, and the place that it is about, m, map frame. None of what the site does not have.
    pub fn place_of_alert(&self, alert: &Alert) -> (Option<InspectionPointId>, Option<Vec3>) {
        let Some(site) = self.site() else { return (None, None) };
        let point = match &alert.cause {
            AlertCause::TaskFailed { mission: Some(mission), task, .. } => {
                let tasks = site.mission(*mission).into_iter().flat_map(|mission| &mission.tasks);
                tasks.into_iter().find(|known| known.id == *task).and_then(|task| match task.place {
                    TaskPlace::InspectionPoint(point) => Some(point),
                    TaskPlace::Node { .. } | TaskPlace::ByAction { .. } => None,
                })
            }
            AlertCause::SceneChange(change) => {
                let is_it = |known: &&SceneChange| known.id == *change;
                return (None, site.scene_changes().find(is_it).map(|change| change.place.centre_m));
            }
            cause => cause.point(),
        };
        let target = point.and_then(|point| site.inspection_point(point));
        (target.map(|point| point.id), target.map(|point| point.target_m))
    }

    /// A new alert of a person, at an inspection point or at none. `now` is the calendar time of the operator's machine.
    pub fn raising_alert(&self, point: Option<InspectionPointId>, now: Utc) -> (AlertId, SiteEdit) {
        let id = AlertId(self.new_id(0));
        let alert = Alert {
            id,
            severity: AlertSeverity::Warning,
            state: AlertState::Open,
            cause: AlertCause::ByHand { point },
            owner: String::new(),
            work_order: String::new(),
            comment: String::new(),
            first_raised: now,
            last_raised: now,
            times_raised: 1,
            recovered: None,
        };
        (id, SiteEdit { put: vec![Object::Alert(alert)], removed: Vec::new() })
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::Robot;
    use super::*;
    use crate::ClientCommand;
    use crate::testing::TestClient;
    use vocab::MapId;

    #[test]
    fn an_alert_of_a_person_is_raised_closed_and_open_again_after_undo() {
        let robot = Robot::default();
        let mut client = TestClient::with_site(&robot);
        let map = MapId(uuid::Uuid::from_u128(3));
        let (node, edit) = client.model.site.adding_node(Vec3::default(), map, None);
        client.command(ClientCommand::EditSite(edit));
        let target = Vec3::new(2.0, 0.0, 1.0);
        let (point, edit) = client.model.site.adding_inspection_point(node, target);
        client.command(ClientCommand::EditSite(edit));
        for at in [5, 9] {
            let (_, edit) = client.model.site.raising_alert(Some(point), Utc(at));
            client.command(ClientCommand::EditSite(edit));
        }
        let alerts = client.model.site.alerts();
        assert_eq!(alerts.iter().map(|alert| alert.last_raised).collect::<Vec<_>>(), [Utc(9), Utc(5)]);
        assert_eq!(client.model.site.place_of_alert(alerts[0]), (Some(point), Some(target)));
        let state = AlertState::Closed { by: "Ada".to_owned(), at: Utc(10), remark: "done".to_owned() };
        let closed = Alert { state, severity: AlertSeverity::Critical, ..alerts[1].clone() };
        let put = vec![Object::Alert(closed)];
        client.command(ClientCommand::EditSite(SiteEdit { put, removed: Vec::new() }));
        let shown = |client: &TestClient| {
            let alerts = client.model.site.alerts();
            alerts.iter().map(|alert| (alert.last_raised.0, alert.state.is_closed())).collect::<Vec<_>>()
        };
        assert_eq!(shown(&client), [(5, true), (9, false)], "the worst first");
        assert_eq!(client.model.site.unseen_findings(), 1);
        client.command(ClientCommand::Undo);
        assert_eq!(shown(&client), [(9, false), (5, false)]);
    }
}
