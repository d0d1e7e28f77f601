//! A client on the Missions screen, for the tests of several panels.

use super::{TestClient, map};
use crate::screens;
use api::{Event, SiteParts, SiteState};
use client_model::{ClientCommand, ClientEvent, ClientTime, MissionEditorCommand, NewTask, SiteEdit};
use site_model::{
    ActionRequest, Dock, DockId, Edge, EdgeId, EditId, InspectionPoint, InspectionPointId, Mission, Node,
    NodeId, NodeKind, Object, Parameters, PoseTolerance, Site, SiteSettings, TaskPlace,
};
use std::sync::Arc;
use uuid::Uuid;
use vocab::{Pose, Vec3};

fn node_id(number: u128) -> NodeId {
    NodeId(Uuid::from_u128(number))
}

/// The entry of the palette of an inspection point.
pub(crate) fn point(number: u128) -> NewTask {
    NewTask::InspectionPoint(InspectionPointId(Uuid::from_u128(number)))
}

/// The entry of the palette of a node.
pub(crate) fn node(number: u128) -> NewTask {
    NewTask::Node(node_id(number))
}

/// Nodes N1 to N5 in a row, 7 m apart (10 s), joined both ways; a dock on N1 and the inspection points P2 to P5 at the others. N9 is joined to none.
fn site() -> Site {
    let mut site = Site::default();
    let mut put = |object: Object| {
        let edit = site.put(EditId(Uuid::nil()), object);
        site.apply(&edit, EditId(Uuid::nil())).expect("of this state");
    };
    let map = Some(map(9, "Hall").id);
    put(Object::Settings(SiteSettings { name: "Site".to_owned(), time_zone: "UTC".to_owned(), map }));
    for number in [1, 2, 3, 4, 5, 9] {
        put(Object::Node(Node {
            id: node_id(number),
            name: format!("N{number}"),
            kind: NodeKind::Waypoint,
            map_from_node: Pose { position: Vec3::new(7.0 * number as f64, 0.0, 0.5), ..Pose::IDENTITY },
            anchor: None,
            tolerance: PoseTolerance::default(),
            influence_area_m: Vec::new(),
            floor: 0,
            tags: Default::default(),
            properties: Default::default(),
        }));
    }
    for number in 2..=5 {
        for (from, to) in [(number - 1, number), (number, number - 1)] {
            let id = EdgeId(Uuid::from_u128(100 * from + to));
            put(Object::Edge(Edge::walk(id, node_id(from), node_id(to))));
        }
        put(Object::InspectionPoint(InspectionPoint {
            id: InspectionPointId(Uuid::from_u128(number)),
            name: format!("P{number}"),
            asset: None,
            node: node_id(number),
            target_m: Vec3::new(0.0, 2.0, 1.0),
            request: ActionRequest { action: "photo".to_owned(), parameters: Parameters::new() },
            limits: None,
            gauge: None,
        }));
    }
    let (id, name) = (DockId(Uuid::from_u128(1)), "Dock".to_owned());
    put(Object::Dock(Dock { id, name, node: node_id(1), approach: node_id(1) }));
    site
}

/// The list of missions, of a site without any.
pub(crate) fn client() -> TestClient {
    of_site(site())
}

fn of_site(site: Site) -> TestClient {
    let hall = map(9, "Hall");
    let id = hall.id;
    let state = SiteState { site, ..SiteState::default() };
    TestClient::connected()
        .event(Event::Maps(vec![hall]))
        .event(Event::SitePart(SiteParts::new(Arc::new(state)).next_part()))
        .command(ClientCommand::ViewMap(Some(id)))
        .on(screens::MISSIONS)
}

/// The editor of a mission of these entries of the palette.
pub(crate) fn with_mission(tasks: &[NewTask]) -> TestClient {
    let client = client();
    let (mission, edit) = client.model.site.adding_mission();
    let mut client = client
        .command(ClientCommand::EditSite(edit))
        .command(ClientCommand::MissionEditor(MissionEditorCommand::Open(Some(mission))));
    for task in tasks {
        let (_, edit) = client.model.missions.adding(*task, &client.model.site);
        client = client.command(ClientCommand::EditSite(edit));
    }
    client
}

/// With this object in the site.
pub(crate) fn put(client: TestClient, object: Object) -> TestClient {
    client.command(ClientCommand::EditSite(SiteEdit { put: vec![object], removed: Vec::new() }))
}

/// The mission that is edited.
pub(crate) fn mission(client: &TestClient) -> &Mission {
    let site = client.model.site.site().expect("loaded");
    client.model.missions.open().and_then(|open| site.mission(open)).expect("open")
}

/// The places of its tasks.
pub(crate) fn names(client: &TestClient) -> Vec<String> {
    let name = |place: &TaskPlace| match place {
        TaskPlace::InspectionPoint(point) => format!("P{}", point.0.as_u128()),
        TaskPlace::Node { node, .. } => format!("N{}", node.0.as_u128()),
        TaskPlace::ByAction { request } => request.action.clone(),
    };
    mission(client).tasks.iter().map(|task| name(&task.place)).collect()
}

/// Carries out what the panels emitted.
pub(crate) fn carry_out(harness: &mut egui_kittest::Harness<'_, TestClient>) {
    let client = harness.state_mut();
    for command in std::mem::take(&mut client.commands) {
        client.model.handle_event(ClientTime(1.0), ClientEvent::Command(command), &mut Vec::new());
    }
    harness.run_steps(2);
}

/// Clicks the control of this name and carries out what the panels emitted.
pub(crate) fn press(harness: &mut egui_kittest::Harness<'_, TestClient>, name: &str) {
    super::click(harness, name);
    carry_out(harness);
}

/// Undoes the last step.
pub(crate) fn undo(harness: &mut egui_kittest::Harness<'_, TestClient>) {
    harness.state_mut().commands.push(ClientCommand::Undo);
    carry_out(harness);
}

/// Types a text into the field of this name in place of what it has, and presses Enter.
pub(crate) fn type_into(harness: &mut egui_kittest::Harness<'_, TestClient>, name: &str, text: &str) {
    use egui_kittest::kittest::Queryable;

    harness.get_by_label(name).focus();
    harness.run_steps(2);
    // Where it was edited before, the cursor is still there.
    harness.key_press(egui::Key::End);
    for _ in 0..super::value(harness, name).chars().count() {
        harness.key_press(egui::Key::Backspace);
    }
    harness.run_steps(2);
    harness.get_by_label(name).type_text(text);
    harness.run_steps(2);
    harness.key_press(egui::Key::Enter);
    harness.run_steps(2);
    carry_out(harness);
}

/// The same client after the robot has all edits.
pub(crate) fn confirmed(client: &TestClient) -> TestClient {
    let open = client.model.missions.open();
    let site = client.model.site.site().expect("loaded").clone();
    of_site(site).command(ClientCommand::MissionEditor(MissionEditorCommand::Open(open)))
}
