use super::*;
use site_model::{ActionRequest, InspectionPoint, InspectionPointId, NodeId};

const POINT: InspectionPointId = InspectionPointId(Uuid::from_u128(9));
const TASK: TaskId = TaskId(Uuid::from_u128(4));

/// A site with an inspection point whose readings are to be 4 to 5 bar.
fn site() -> Site {
    let mut site = Site::default();
    let limits = ReadingLimits { min: Some(4.0), max: Some(5.0), unit: "bar".to_owned() };
    put(
        &mut site,
        Object::InspectionPoint(InspectionPoint {
            id: POINT,
            name: "Boiler".to_owned(),
            asset: None,
            node: NodeId(Uuid::from_u128(2)),
            target_m: vocab::Vec3::default(),
            request: ActionRequest { action: "photo".to_owned(), parameters: Default::default() },
            limits: Some(limits),
            gauge: None,
        }),
    );
    site
}

fn put(site: &mut Site, object: Object) {
    let edit = site.put(EditId(Uuid::nil()), object);
    site.apply(&edit, EditId(Uuid::nil())).expect("of this state");
}

fn result(step: u32, at: i64, value: serde_json::Value) -> StoredResult {
    StoredResult {
        number: u64::from(step) + 100,
        run: RunId(Uuid::from_u128(3)),
        step,
        attempt: 1,
        kind: "photo".to_owned(),
        blob: None,
        body: serde_json::json!({ "inspection_point": POINT, "value": value }).to_string(),
        at: Stamp::from_nanos(at),
        comparison: None,
    }
}

fn report(readings: &[(&str, f64)]) -> serde_json::Value {
    let reading =
        |(name, value): &(&str, f64)| serde_json::json!({ "name": name, "value": value, "unit": "bar" });
    serde_json::json!({ "at": site_model::ReportTime::default(), "readings": readings.iter().map(reading).collect::<Vec<_>>() })
}

fn gauge(value: serde_json::Value) -> serde_json::Value {
    serde_json::json!({ "at": site_model::ReportTime::default(), "gauge": value })
}

/// Applies what a result leads to. Returns the number of changes.
fn apply(site: &mut Site, result: &StoredResult, max_alerts: usize) -> usize {
    let edit = edit_of_result(site, result, &AlertsConfig { max_alerts });
    site.apply(&edit, EditId(Uuid::nil())).expect("of this state");
    edit.changes.len()
}

fn decide(site: &mut Site, state: AlertState) {
    let open = site.alerts().find(|alert| !alert.state.is_closed()).expect("one is there").clone();
    put(site, Object::Alert(Alert { state, owner: "Ada".to_owned(), ..open }));
}

fn acknowledged() -> AlertState {
    AlertState::Acknowledged { by: "Ada".to_owned(), at: Utc(1) }
}

fn closed() -> AlertState {
    AlertState::Closed { by: "Ada".to_owned(), at: Utc(1), remark: "new valve".to_owned() }
}

#[test]
fn the_same_reading_outside_is_one_alert_until_it_is_closed() {
    let mut site = site();
    assert_eq!(apply(&mut site, &result(0, 10, report(&[("pressure", 4.5)])), 9), 0);
    apply(&mut site, &result(1, 20, report(&[("pressure", 5.3)])), 9);
    decide(&mut site, acknowledged());
    apply(&mut site, &result(2, 30, report(&[("pressure", 3.9)])), 9);
    let alert = site.alerts().next().expect("raised").clone();
    assert_eq!((alert.first_raised, alert.last_raised, alert.times_raised), (Utc(20), Utc(30), 2));
    assert_eq!((&alert.state, alert.owner.as_str()), (&acknowledged(), "Ada"));
    let AlertCause::OutsideLimits { point: POINT, result: 102, reading, .. } = &alert.cause else {
        panic!("{alert:?}")
    };
    assert_eq!((reading.value, reading.outside), (3.9, OutsideLimits::Below(4.0)));

    // Back within the limits: told once, and not closed.
    assert_eq!(apply(&mut site, &result(3, 40, report(&[("pressure", 4.2)])), 9), 1);
    assert_eq!(apply(&mut site, &result(4, 50, report(&[("pressure", 4.3)])), 9), 0);
    let alert = site.alerts().next().expect("kept");
    assert_eq!((alert.recovered, &alert.state), (Some(Utc(40)), &acknowledged()));
    apply(&mut site, &result(5, 60, report(&[("pressure", 5.1)])), 9);
    assert_eq!(site.alerts().next().expect("kept").recovered, None);

    decide(&mut site, closed());
    apply(&mut site, &result(6, 70, report(&[("pressure", 5.2)])), 9);
    let counts: Vec<u32> = site.alerts().map(|alert| alert.times_raised).collect();
    assert_eq!(counts.iter().sum::<u32>(), 4, "{counts:?}");
    assert_eq!(counts.len(), 2);
}

#[test]
fn readings_far_outside_are_critical_and_one_that_becomes_so_is_open_again() {
    let mut site = site();
    apply(&mut site, &result(0, 10, report(&[("pressure", 6.0), ("reserve", 2.9)])), 9);
    let severity = |site: &Site, name: &str| {
        let alert = site.alerts().find(|alert| alert.cause.key() == Some(AlertKey::Reading(POINT, name)));
        let alert = alert.expect("raised");
        (alert.severity, alert.state.name())
    };
    assert_eq!(severity(&site, "pressure"), (AlertSeverity::Warning, "open"), "exactly the span");
    assert_eq!(severity(&site, "reserve"), (AlertSeverity::Critical, "open"));
    let pressure = site.alerts().find(|alert| alert.severity == AlertSeverity::Warning).cloned();
    put(&mut site, Object::Alert(Alert { state: acknowledged(), ..pressure.expect("raised") }));
    apply(&mut site, &result(1, 20, report(&[("pressure", 6.1)])), 9);
    assert_eq!(severity(&site, "pressure"), (AlertSeverity::Critical, "open"));
}

#[test]
fn a_gauge_that_was_not_read_is_good_to_know_until_it_is_read() {
    let mut site = site();
    apply(&mut site, &result(0, 10, gauge(serde_json::json!({ "problem": "It is dark." }))), 9);
    let alert = site.alerts().next().expect("raised").clone();
    assert_eq!((alert.severity, alert.cause.name()), (AlertSeverity::Information, "gauge_not_read"));
    apply(&mut site, &result(1, 20, gauge(serde_json::json!({}))), 9);
    assert_eq!(site.alerts().next().expect("kept").recovered, Some(Utc(20)));
}

#[test]
fn a_task_that_has_failed_for_good_is_an_alert_until_it_succeeds() {
    let mut site = site();
    let step = |attempt: u32, step: TaskStep, more: serde_json::Value| {
        let state = step.state();
        let mut body = serde_json::json!({ "task": TASK, "node": null, "step": step });
        if let (Some(body), Some(more)) = (body.as_object_mut(), more.as_object()) {
            body.extend(more.clone());
        }
        StepRecord {
            run: RunId(Uuid::from_u128(3)),
            step: 0,
            attempt,
            state: format!("{state:?}"),
            is_done: state.is_outcome(),
            body: body.to_string(),
        }
    };
    let failure = || site_model::TaskFailure::ActionFailed("no light".to_owned());
    let mut count = |record: StepRecord| {
        let edit = edit_of_step(&site, &record, Stamp::from_nanos(10), &AlertsConfig::default());
        site.apply(&edit, EditId(Uuid::nil())).expect("of this state");
        let alerts: Vec<Alert> = site.alerts().cloned().collect();
        (alerts.len(), alerts.first().is_some_and(|alert| alert.recovered.is_some()))
    };
    assert_eq!(count(step(1, TaskStep::TriesAgain(failure()), serde_json::json!({}))), (0, false));
    let on_the_way = serde_json::json!({ "place": { "edge": "x" } });
    assert_eq!(count(step(1, TaskStep::Failed(failure()), on_the_way)), (0, false));
    assert_eq!(count(step(2, TaskStep::Failed(failure()), serde_json::json!({}))), (1, false));
    let done = TaskStep::Succeeded { result: None };
    assert_eq!(count(step(3, done, serde_json::json!({}))), (1, true));
}

#[test]
fn closed_alerts_make_room_and_others_never_do() {
    let mut site = site();
    apply(&mut site, &result(0, 10, report(&[("a", 5.3)])), 2);
    decide(&mut site, closed());
    apply(&mut site, &result(1, 20, report(&[("b", 5.3), ("c", 5.3), ("d", 5.3)])), 2);
    let mut names: Vec<String> = site
        .alerts()
        .filter_map(|alert| match alert.cause.key() {
            Some(AlertKey::Reading(_, name)) => Some(name.to_owned()),
            _ => None,
        })
        .collect();
    names.sort();
    assert_eq!(names, ["b", "c", "d"]);
}

#[test]
fn readings_of_one_name_in_one_result_are_one_alert() {
    let mut site = site();
    assert_eq!(apply(&mut site, &result(0, 10, report(&[("a", 5.3), ("a", 5.4), ("a", 4.5)])), 9), 1);
    assert_eq!(apply(&mut site, &result(1, 20, report(&[("a", 5.3), ("a", 4.5)])), 9), 1);
    let alert = site.alerts().next().expect("raised");
    assert_eq!((alert.times_raised, alert.recovered), (2, None));
}
