//! Alerts by their panel.

use crate::page_clock::PageClock;
use crate::screens;
use crate::test_support::missions::{carry_out, press, type_into, undo};
use crate::test_support::{TestClient, click};
use api::{Event, SiteParts, SiteState};
use client_model::{CameraMove, ClientCommand, PointHistoryCommand};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use site_model::{
    ActionRequest, Alert, AlertCause, AlertId, AlertSeverity, AlertState, EditId, InspectionPoint,
    InspectionPointId, NodeId, Object, OutsideLimits, OutsideReading, RunId, Utc,
};
use std::sync::Arc;
use uuid::Uuid;
use vocab::Vec3;

const HOUR_NS: i64 = 3_600_000_000_000;
/// When the list is looked at.
const NOW: Utc = Utc(1_000 * HOUR_NS);
const BOILER: InspectionPointId = InspectionPointId(Uuid::from_u128(9));
const TARGET_M: Vec3 = Vec3::new(2.0, 3.0, 1.0);

fn alert(number: u128, severity: AlertSeverity, age_h: i64, cause: AlertCause) -> Object {
    let raised = Utc(NOW.0 - age_h * HOUR_NS);
    Object::Alert(Alert {
        id: AlertId(Uuid::from_u128(number)),
        severity,
        state: AlertState::Open,
        cause,
        owner: String::new(),
        work_order: String::new(),
        comment: String::new(),
        first_raised: raised,
        last_raised: raised,
        times_raised: 1,
        recovered: None,
    })
}

/// The Runs screen of a robot with two open alerts, with their tab open.
fn shown<'a>(width: f32) -> Harness<'a, TestClient> {
    let mut state = SiteState::default();
    let boiler = InspectionPoint {
        id: BOILER,
        name: "Boiler".to_owned(),
        asset: None,
        node: NodeId(Uuid::from_u128(2)),
        target_m: TARGET_M,
        request: ActionRequest { action: "photo".to_owned(), parameters: Default::default() },
        limits: None,
        gauge: None,
    };
    let reading = OutsideReading {
        name: "gauge".to_owned(),
        value: 5.3,
        unit: "bar".to_owned(),
        outside: OutsideLimits::Above(5.0),
    };
    let run = RunId(Uuid::from_u128(5));
    let outside = AlertCause::OutsideLimits { point: BOILER, run, result: 7, reading };
    let dark = AlertCause::GaugeNotRead { point: BOILER, run, result: 8, reason: "It is dark.".to_owned() };
    for object in [
        Object::InspectionPoint(boiler),
        alert(1, AlertSeverity::Warning, 2, outside),
        alert(2, AlertSeverity::Information, 48, dark),
    ] {
        let edit = state.site.put(EditId(Uuid::nil()), object);
        state.site.apply(&edit, EditId(Uuid::nil())).expect("of this state");
    }
    let part = SiteParts::new(Arc::new(state)).next_part();
    let mut client = TestClient::connected().event(Event::SitePart(part)).on(screens::RUNS);
    client.panels.clock = PageClock { utc: NOW, ..PageClock::default() };
    let mut harness = client.shown(width, 2400.0);
    click(&mut harness, super::texts::TAB);
    harness.run_steps(2);
    harness
}

/// The alert of the reading.
fn warning(harness: &Harness<'_, TestClient>) -> Alert {
    let alerts = harness.state().model.site.alerts();
    (*alerts.iter().find(|alert| alert.id == AlertId(Uuid::from_u128(1))).expect("there")).clone()
}

const WARNING: &str = "Warning · Boiler · 2 h 00 old";
const NOT_READ: &str = "Information · Boiler · 2 days old";

#[test]
fn the_list_says_how_bad_what_where_how_old_and_who() {
    let harness = shown(1440.0);
    for text in [WARNING, NOT_READ, "Gauge 5.30 bar, above 5.00 bar", "It is dark."] {
        assert!(harness.query_by_label(text).is_some(), "{text}");
    }
    assert_eq!(harness.query_all_by_label("Nobody yet").count(), 2);
}

#[test]
fn an_alert_is_acknowledged_given_to_somebody_and_closed_and_that_is_undone() {
    let mut harness = shown(1440.0);
    press(&mut harness, WARNING);
    press(&mut harness, "Acknowledge");
    let me = harness.state().model.operator_name();
    assert_eq!(warning(&harness).state, AlertState::Acknowledged { by: me.clone(), at: NOW });
    press(&mut harness, "I look after it");
    assert_eq!(warning(&harness).owner, me);
    assert!(harness.query_by_label("Keep the owner").is_none(), "the field shows who looks after it now");
    type_into(&mut harness, "Owner", "");
    assert_eq!(warning(&harness).owner, "", "nobody again");
    press(&mut harness, "I look after it");
    type_into(&mut harness, "Work order", "Replace the valve");
    press(&mut harness, "Keep the work order");
    assert_eq!(warning(&harness).work_order, "Replace the valve");
    assert!(harness.query_by_label(&format!("{me}: Replace the valve")).is_some());
    press(&mut harness, "Critical");
    assert_eq!(warning(&harness).severity, AlertSeverity::Critical);
    type_into(&mut harness, "Closing remark", "New valve");
    press(&mut harness, "Close the alert");
    let closed = AlertState::Closed { by: me.clone(), at: NOW, remark: "New valve".to_owned() };
    assert_eq!(warning(&harness).state, closed);
    undo(&mut harness);
    assert_eq!(warning(&harness).state, AlertState::Acknowledged { by: me, at: NOW });
    press(&mut harness, "Open again");
    assert_eq!(warning(&harness).state, AlertState::Open);
}

#[test]
fn the_list_is_filtered_by_state() {
    let mut harness = shown(1440.0);
    press(&mut harness, WARNING);
    press(&mut harness, "Acknowledge");
    press(&mut harness, WARNING);
    let listed = |harness: &Harness<'_, TestClient>| {
        [WARNING, NOT_READ].map(|row| harness.query_by_label(row).is_some())
    };
    assert_eq!(listed(&harness), [false, true]);
    press(&mut harness, "Acknowledged");
    assert_eq!(listed(&harness), [true, false]);
    press(&mut harness, "Closed");
    assert_eq!(listed(&harness), [false, false]);
    press(&mut harness, "All");
    assert_eq!(listed(&harness), [true, true]);
}

#[test]
fn an_alert_leads_to_its_place_and_to_the_history_of_its_point() {
    let mut harness = shown(1440.0);
    press(&mut harness, WARNING);
    click(&mut harness, "Show the place");
    assert!(harness.state().emitted(&ClientCommand::MoveCamera(CameraMove::Point(TARGET_M))));
    click(&mut harness, "History of this point");
    assert!(harness.state().emitted(&ClientCommand::PointHistory(PointHistoryCommand::Open(BOILER))));
}

#[test]
fn a_person_raises_an_alert_at_the_point_that_is_selected() {
    let mut harness = shown(1440.0);
    assert!(harness.query_by_label("Raise an alert").is_some());
    let select = ClientCommand::Select(Some(client_model::Selection::InspectionPoint(BOILER)));
    harness.state_mut().commands.push(select);
    carry_out(&mut harness);
    press(&mut harness, "Raise an alert at Boiler");
    let alerts = harness.state().model.site.alerts();
    let raised = alerts.iter().find(|alert| alert.cause.name() == "by_hand").expect("raised");
    assert_eq!((raised.cause.point(), raised.first_raised), (Some(BOILER), NOW));
    assert!(harness.query_by_label("Closing remark").is_some(), "it is unfolded");
}
