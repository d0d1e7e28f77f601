//! The documents of the site over HTTP and the control socket. A made-up core applies edits in memory.

use crate::support::{Gateway, Reply, TestCore, TestSocket, client_id};
use api::{
    ClientMessage, CoreMessage, EditDone, EditOutcome, EditRefusal, Event, GatewayMessage, Query, QueryReply,
    SiteAssembly, SiteChanged, SiteParts, SiteState, StoredRevision,
};
use serde_json::{Value, json};
use site_model::{Asset, AssetId, Change, Edit, EditError, EditId, Object, ObjectId, Revision};
use std::collections::BTreeMap;
use std::sync::Arc;
use tokio::sync::oneshot;
use uuid::Uuid;
use vocab::Stamp;

const NODE: &str = "11111111-0000-4000-8000-000000000001";
const OTHER: &str = "11111111-0000-4000-8000-000000000002";

/// What the made-up core has.
#[derive(Default)]
struct Site {
    state: SiteState,
    applied: BTreeMap<EditId, EditOutcome>,
}

impl Site {
    /// Applies an edit, publishes it, and returns its answer.
    async fn apply(&mut self, core: &mut TestCore, by: Option<vocab::ClientId>, edit: Edit) -> EditOutcome {
        if let Some(outcome) = self.applied.get(&edit.id) {
            return outcome.clone();
        }
        let errors: Vec<_> = self.state.site.edit_errors(&edit).collect();
        let Ok(applied) = self.state.site.apply(&edit, edit.id) else {
            return EditOutcome::Refused(EditRefusal::Invalid(errors));
        };
        self.state.revision += 1;
        let revision = self.state.revision;
        let outcome = EditOutcome::Applied { revision, changes: applied.revisions };
        self.applied.insert(edit.id, outcome.clone());
        core.publish(Event::SiteChanged(SiteChanged { revision, by, edit })).await;
        outcome
    }

    async fn send_whole(&self, core: &mut TestCore) {
        let mut parts = SiteParts::new(Arc::new(self.state.clone()));
        loop {
            let part = parts.next_part();
            let is_last = part.is_last;
            core.publish(Event::SitePart(part)).await;
            if is_last {
                return;
            }
        }
    }

    /// Plays the core until told to end. Returns the site.
    async fn play(mut self, mut core: TestCore, mut end: oneshot::Receiver<()>) -> Self {
        self.send_whole(&mut core).await;
        loop {
            let message = tokio::select! {
                message = core.receive() => message,
                _ = &mut end => return self,
            };
            match message {
                GatewayMessage::Edit { by, edit } => {
                    let id = edit.id;
                    let outcome = self.apply(&mut core, Some(by.client), edit).await;
                    let event = Event::EditDone(EditDone { id, outcome });
                    core.send(&CoreMessage::Event { to: Some(by.client), event }).await;
                }
                GatewayMessage::RequestSite => self.send_whole(&mut core).await,
                GatewayMessage::Query {
                    number, query: Query::Revisions { object, before, limit }, ..
                } => {
                    let current = self.state.site.get(object);
                    let revisions =
                        current.into_iter().take(limit as usize).map(|versioned| StoredRevision {
                            revision: before.unwrap_or(versioned.revision),
                            object: Some(versioned.object.clone()),
                            author: Some(r#"{"role":"Operator"}"#.to_owned()),
                            at: Stamp::from_nanos(5),
                        });
                    let result = Ok(QueryReply::Revisions(revisions.collect()));
                    core.send(&CoreMessage::Reply { number, result }).await;
                }
                _ => {}
            }
        }
    }
}

/// A gateway with a core that has this site.
struct Bench {
    gateway: Gateway,
    end: oneshot::Sender<()>,
    core: tokio::task::JoinHandle<Site>,
}

impl Bench {
    async fn start() -> Self {
        let gateway = Gateway::start().await;
        let core = gateway.core().await;
        let (end, ended) = oneshot::channel();
        let core = tokio::spawn(Site::default().play(core, ended));
        let mut client = gateway.client(1).await;
        whole(&mut client).await;
        Self { gateway, end, core }
    }

    async fn end(self) -> Site {
        self.end.send(()).ok();
        self.core.await.expect("no panic")
    }

    async fn send(&self, method: &str, path: &str, headers: &[&str], body: &Value) -> Reply {
        self.send_text(method, path, headers, &body.to_string()).await
    }

    async fn send_text(&self, method: &str, path: &str, headers: &[&str], body: &str) -> Reply {
        let length = format!("content-length: {}", body.len());
        let headers: Vec<&str> = headers.iter().copied().chain([length.as_str()]).collect();
        self.gateway.send(method, &format!("/api/v1/site{path}"), &headers, body.as_bytes()).await
    }

    async fn get(&self, path: &str) -> Reply {
        self.gateway.get(&format!("/api/v1/site{path}"), &[]).await
    }
}

/// Waits for the whole site at a client.
async fn whole(client: &mut TestSocket) -> SiteState {
    let mut assembly = SiteAssembly::default();
    client
        .find(|event| match event {
            Event::SitePart(part) => assembly.add(part),
            _ => None,
        })
        .await
}

fn node() -> Value {
    let pose = json!({ "position": { "x": 1.5, "y": 0.0, "z": 0.0 }, "orientation": { "w": 1.0, "x": 0.0, "y": 0.0, "z": 0.0 } });
    json!({ "id": NODE, "name": "Gate", "kind": "waypoint", "map_from_node": pose })
}

fn with(mut document: Value, pointer: &str, value: Value) -> Value {
    let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
    match document.pointer_mut(parent).expect("a place in the document") {
        Value::Object(fields) => drop(fields.insert(key.to_owned(), value)),
        Value::Array(items) => items[key.parse::<usize>().expect("an index")] = value,
        _ => panic!("{parent} has no fields"),
    }
    document
}

fn without(mut document: Value, field: &str) -> Value {
    document.as_object_mut().expect("an object").remove(field).expect("a field");
    document
}

#[tokio::test]
async fn an_object_is_made_read_changed_and_removed() {
    let bench = Bench::start().await;
    let path = format!("/nodes/{NODE}");
    bench.get(&path).await.expect_problem(404);
    let made = bench.send("POST", "/nodes", &[], &node()).await;
    assert_eq!((made.status, made.header("etag")), (201, "\"1\""));
    assert_eq!(made.header("location"), format!("/api/v1/site{path}"));
    let read = bench.get(&path).await;
    assert_eq!((read.status, read.header("etag"), &read.json()), (200, "\"1\"", &made.json()));
    assert_eq!(read.json()["tolerance"]["along_m"], 0.1);
    let unchanged = bench.gateway.get(&format!("/api/v1/site{path}"), &["if-none-match: \"1\""]).await;
    assert_eq!(unchanged.status, 304);

    // What was read can be sent back.
    let renamed = with(read.json(), "/name", json!("Gate, north"));
    bench.send("PUT", &path, &[], &renamed).await.expect_problem(428);
    let put = bench.send("PUT", &path, &["if-match: \"1\""], &renamed).await;
    assert_eq!((put.status, put.header("etag"), &put.json()), (200, "\"2\"", &renamed));
    let late = bench.send("PUT", &path, &["if-match: \"1\""], &read.json()).await;
    late.expect_problem(412);
    assert_eq!((&late.json()["current"]["object"], &late.json()["yours"]), (&renamed, &read.json()));
    assert_eq!((late.header("etag"), &late.json()["current"]["revision"]), ("\"2\"", &json!(2)));
    let patched =
        bench.send("PATCH", &path, &["if-match: *"], &json!({ "tags": ["north"], "floor": null })).await;
    assert_eq!((patched.status, &patched.json()["tags"][0]), (200, &json!("north")));

    // Sent again with the same key, it is carried out once.
    let key = format!("idempotency-key: {}", Uuid::from_u128(77));
    let again = json!({ "name": "Gate, south" });
    for _ in 0..2 {
        let patched = bench.send("PATCH", &path, &["if-match: \"3\"", &key], &again).await;
        assert_eq!((patched.status, patched.header("etag")), (200, "\"4\""));
    }
    bench.send("DELETE", &path, &["if-match: \"3\""], &Value::Null).await.expect_problem(412);
    bench.send("DELETE", &path, &[], &Value::Null).await.expect_problem(428);
    let removed = bench.send("DELETE", &path, &["if-match: \"4\""], &Value::Null).await;
    assert_eq!((removed.status, &removed.json()["removed"]), (200, &json!([format!("/api/v1/site{path}")])));
    bench.get(&path).await.expect_problem(404);
    // Made again, it goes on with its revisions.
    let made = bench.send("PUT", &path, &["if-none-match: *"], &node()).await;
    assert_eq!((made.status, made.header("etag")), (201, "\"6\""));
    bench.send("PUT", &path, &["if-none-match: *"], &node()).await.expect_problem(412);
    assert_eq!(bench.end().await.state.revision, 6);
}

#[tokio::test]
async fn lists_come_in_pages_and_the_site_says_what_is_wrong() {
    let bench = Bench::start().await;
    for number in 0..7 {
        let asset = json!({ "name": format!("Pump {number}") });
        assert_eq!(bench.send("POST", "/assets", &[], &asset).await.status, 201);
    }
    let (mut names, mut next) = (Vec::new(), String::new());
    loop {
        let page = bench.get(&format!("/assets?limit=3{next}")).await.json();
        let items = page["items"].as_array().expect("items");
        assert!(items.len() <= 3);
        names.extend(items.iter().map(|item| item["object"]["name"].as_str().expect("a name").to_owned()));
        match page["next"].as_str() {
            Some(id) => next = format!("&after={id}"),
            None => break,
        }
    }
    names.sort();
    assert_eq!(names, (0..7).map(|number| format!("Pump {number}")).collect::<Vec<_>>());
    let site = bench.get("").await.json();
    assert_eq!((&site["revision"], &site["objects"]["assets"]), (&json!(7), &json!(7)));
    assert_eq!(site["problems"][0]["detail"], "the site has no settings.");
    let settings = json!({ "name": "Works", "time_zone": "Europe/London" });
    assert_eq!(bench.send("PUT", "/settings/main", &[], &settings).await.status, 201);
    assert_eq!(bench.get("").await.json()["problem_count"], 0);
    let id = bench.get("/assets?limit=1").await.json()["items"][0]["object"]["id"].clone();
    let revisions =
        bench.get(&format!("/assets/{}/revisions?before=9", id.as_str().expect("an id"))).await.json();
    assert_eq!((&revisions["items"][0]["revision"], &revisions["next"]), (&json!(9), &json!(9)));
    for bad in [
        "/assets?limit=x",
        "/assets?after=x",
        "/assets?size=3",
        &format!("/assets/{NODE}/revisions?before=-1"),
    ] {
        bench.get(bad).await.expect_problem(400);
    }
    bench.get("/pumps").await.expect_problem(404);
    bench.end().await;
}

#[tokio::test]
async fn several_objects_are_changed_together_or_not_at_all() {
    let bench = Bench::start().await;
    let edge = |id: &str, to: &str| json!({ "id": id, "from": NODE, "to": to, "traversal": "walk", "is_enabled": true });
    let put = |kind: &str, object: Value| json!({ "put": { "base": null, "object": { kind: object } } });
    let id = Uuid::from_u128(5).to_string();
    // The edge leads to a node that is not there.
    let edges = json!({ "id": id, "changes": [put("node", node()), put("edge", edge(OTHER, OTHER))] });
    let refused = bench.send("POST", "/edits", &[], &edges).await;
    refused.expect_problem(422);
    assert_eq!(refused.json()["errors"][0]["pointer"], "/changes/1/put/object/edge/to");
    let other = with(node(), "/id", json!(OTHER));
    let good = json!({ "id": id, "changes": [put("node", node()), put("edge", edge(NODE, OTHER)), put("node", with(other, "/name", json!("Pump")))] });
    let done = bench.send("POST", "/edits", &[], &good).await;
    assert_eq!((done.status, &done.json()["revision"]), (200, &json!(1)));
    assert_eq!(done.json()["changes"][2], json!({ "object": { "node": OTHER }, "before": null, "after": 1 }));
    // Again: the same answer.
    assert_eq!(bench.send("POST", "/edits", &[], &good).await.json(), done.json());
    let late = with(good, "/id", json!(Uuid::from_u128(6).to_string()));
    let late = bench.send("POST", "/edits", &[], &late).await;
    late.expect_problem(412);
    assert_eq!(late.json()["errors"].as_array().map(Vec::len), Some(3));
    // With a node goes its edge.
    let removed = bench.send("DELETE", &format!("/nodes/{NODE}"), &["if-match: *"], &Value::Null).await;
    assert_eq!(removed.json()["removed"].as_array().map(Vec::len), Some(2));
    let site = bench.end().await;
    assert_eq!((site.state.revision, site.state.site.objects().len()), (2, 1));
}

#[tokio::test]
async fn each_mistake_is_named_by_its_field_and_nothing_is_stored() {
    let bench = Bench::start().await;
    let mission =
        json!({ "name": "Round", "tasks": [{ "id": NODE, "place": { "node": { "node": OTHER } } }] });
    let schedule = json!({ "name": "Daily", "mission": NODE, "recurrence": { "once": {
        "date": { "year": 2026, "month": 11, "day": 24 }, "time": { "hour": 11, "minute": 0 } } } });
    let zone =
        json!({ "name": "Lab", "corners_m": [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], "effect": "keep_out" });
    let monitor = json!({ "name": "Battery", "signal": "battery.charge", "is_enabled": true, "response": "pause",
        "condition": { "below": { "threshold": 0.3, "release": 0.2 } } });
    let edge = json!({ "from": NODE, "to": NODE, "traversal": "walk", "is_enabled": true });
    let point = json!({ "name": "Gauge", "node": NODE, "target_m": { "x": 0.0, "y": 0.0, "z": 0.0 }, "request": { "action": "photo" } });
    let put =
        |object: Value| json!({ "id": NODE, "changes": [{ "put": { "base": null, "object": object } }] });
    let deep = (0..60).fold(json!(1), |inner, _| json!([inner]));
    // Method, path, document, status, pointer of the field.
    let cases: Vec<(&str, &str, String, u16, &str)> = [
        ("POST", "/nodes", json!([]), 400, ""),
        ("POST", "/nodes", json!("Gate"), 400, ""),
        ("POST", "/nodes", without(node(), "name"), 400, "/name"),
        ("POST", "/nodes", without(node(), "map_from_node"), 400, "/map_from_node"),
        ("POST", "/nodes", with(node(), "/id", json!("gate")), 400, "/id"),
        ("POST", "/nodes", with(node(), "/id", json!(7)), 400, "/id"),
        ("POST", "/nodes", with(node(), "/kind", json!("gate")), 400, "/kind"),
        ("POST", "/nodes", with(node(), "/nmae", json!("Gate")), 400, "/nmae"),
        (
            "POST",
            "/nodes",
            with(node(), "/map_from_node/position/x", json!("1")),
            400,
            "/map_from_node/position/x",
        ),
        (
            "POST",
            "/nodes",
            with(node(), "/map_from_node/position/w", json!(1)),
            400,
            "/map_from_node/position/w",
        ),
        ("POST", "/nodes", with(node(), "/floor", json!(0.5)), 400, "/floor"),
        ("POST", "/nodes", with(node(), "/tags", json!(["a", 5])), 400, "/tags/1"),
        (
            "POST",
            "/nodes",
            with(node(), "/tolerance", json!({ "along_m": 0.0, "across_m": 0.1, "yaw_rad": 0.1 })),
            422,
            "/tolerance/along_m",
        ),
        (
            "POST",
            "/nodes",
            with(node(), "/influence_area_m", json!([[0.0, 0.0], [1.0, 1.0]])),
            422,
            "/influence_area_m",
        ),
        ("POST", "/edges", edge.clone(), 422, "/from"),
        (
            "POST",
            "/edges",
            with(edge.clone(), "/fail_policy", json!([{ "retry": 300 }])),
            400,
            "/fail_policy/0/retry",
        ),
        (
            "POST",
            "/edges",
            with(edge, "/traversal", json!({ "action": { "name": "lift", "parameters": { "a": deep } } })),
            400,
            "/traversal/action/parameters/a",
        ),
        ("POST", "/missions", mission.clone(), 422, "/tasks/0/place/node/node"),
        (
            "POST",
            "/missions",
            with(mission.clone(), "/tasks/0/on_unreachable", json!({ "retries": 1, "then": "dance" })),
            400,
            "/tasks/0/on_unreachable/then",
        ),
        (
            "POST",
            "/missions",
            with(
                mission.clone(),
                "/tasks/0/place",
                json!({ "node": { "node": OTHER, "request": { "action": "" } } }),
            ),
            422,
            "/tasks/0/place/node/request/action",
        ),
        (
            "POST",
            "/missions",
            with(
                mission.clone(),
                "/tasks/0/place",
                json!({ "node": { "node": OTHER, "request": { "action": "wait", "parameters": { "duration_s": -1 } } } }),
            ),
            422,
            "/tasks/0/place/node/request/parameters/duration_s",
        ),
        ("POST", "/missions", with(mission.clone(), "/tasks/0/place", json!("here")), 400, "/tasks/0/place"),
        ("POST", "/missions", with(mission.clone(), "/order", json!("any")), 400, "/order"),
        ("POST", "/missions", without(mission, "tasks"), 400, "/tasks"),
        ("POST", "/schedules", schedule.clone(), 422, "/mission"),
        (
            "POST",
            "/schedules",
            with(schedule.clone(), "/recurrence/once/date/month", json!(13)),
            422,
            "/recurrence",
        ),
        (
            "POST",
            "/schedules",
            with(schedule.clone(), "/recurrence/once/date/month", json!(300)),
            400,
            "/recurrence/once/date/month",
        ),
        ("POST", "/schedules", with(schedule.clone(), "/recurrence", json!({ "daily": {} })), 400, "/recurrence"),
        ("POST", "/schedules", with(schedule.clone(), "/mission", json!("round")), 400, "/mission"),
        ("POST", "/schedules", without(schedule.clone(), "recurrence"), 400, "/recurrence"),
        ("POST", "/schedules", with(schedule, "/grace", json!(-1)), 422, "/grace"),
        ("POST", "/zones", with(zone.clone(), "/corners_m/0", json!([1.0])), 400, "/corners_m/0"),
        ("POST", "/zones", with(zone.clone(), "/corners_m", json!([[0.0, 0.0]])), 422, "/corners_m"),
        ("POST", "/zones", with(zone, "/effect", json!({ "speed_limit": 9.0 })), 422, "/effect/speed_limit"),
        ("POST", "/monitors", monitor, 422, "/condition/below/release"),
        ("POST", "/inspection-points", point.clone(), 422, "/node"),
        (
            "POST",
            "/inspection-points",
            with(point.clone(), "/request/parameters", json!({ "zoom": "far" })),
            422,
            "/request/parameters/zoom",
        ),
        (
            "POST",
            "/inspection-points",
            with(point.clone(), "/request/parameters", json!({ "zoom": 21 })),
            422,
            "/request/parameters/zoom",
        ),
        (
            "POST",
            "/inspection-points",
            with(point.clone(), "/request/parameters", json!({ "target_m": [1, 2] })),
            422,
            "/request/parameters/target_m",
        ),
        (
            "POST",
            "/inspection-points",
            with(point.clone(), "/request/parameters", json!({ "flash": true })),
            422,
            "/request/parameters",
        ),
        (
            "POST",
            "/inspection-points",
            with(point.clone(), "/request", json!({ "action": "message" })),
            422,
            "/request/parameters",
        ),
        (
            "POST",
            "/inspection-points",
            with(
                point.clone(),
                "/request",
                json!({ "action": "message", "parameters": { "text": "x".repeat(201) } }),
            ),
            422,
            "/request/parameters/text",
        ),
        ("POST", "/inspection-points", with(point, "/request/action", json!(" ")), 422, "/request/action"),
        (
            "PUT",
            "/assets/11111111-0000-4000-8000-000000000001",
            json!({ "id": OTHER, "name": "Pump" }),
            400,
            "/id",
        ),
        ("PUT", "/settings/main", json!({ "name": "Works" }), 400, "/time_zone"),
        ("POST", "/edits", json!({ "id": NODE }), 400, "/changes"),
        ("POST", "/edits", put(json!({ "pump": {} })), 400, "/changes/0/put/object"),
        ("POST", "/edits", put(json!({ "asset": { "id": NODE } })), 400, "/changes/0/put/object/asset/name"),
        (
            "POST",
            "/edits",
            json!({ "id": NODE, "changes": [{ "remove": { "base": 1, "object": { "node": NODE } } }] }),
            412,
            "/changes/0/remove/base",
        ),
    ]
    .into_iter()
    .map(|(method, path, document, status, pointer)| (method, path, document.to_string(), status, pointer))
    .collect();
    let raw = [
        ("POST", "/nodes", "{", 400, ""),
        ("POST", "/nodes", "{\"name\": \"a\"} {}", 400, ""),
        ("POST", "/nodes", "{\"name\": 1e999}", 400, "/name"),
        ("POST", "/assets", "{\"name\": \"a\", \"name\": \"b\", \"tags\": 1}", 400, "/tags"),
    ];
    let raw =
        raw.map(|(method, path, body, status, pointer)| (method, path, body.to_owned(), status, pointer));
    let mut count = 0;
    for (method, path, body, status, pointer) in cases.into_iter().chain(raw) {
        let reply = bench.send_text(method, path, &[], &body).await;
        let said = String::from_utf8_lossy(&reply.body).into_owned();
        assert_eq!(reply.status, status, "{body}: {said}");
        reply.expect_problem(status);
        let pointers: Vec<_> = reply.json()["errors"]
            .as_array()
            .into_iter()
            .flatten()
            .map(|error| error["pointer"].clone())
            .collect();
        // Of a single conflict the versions are told instead.
        if reply.json().get("current").is_none() {
            assert!(pointers.contains(&json!(pointer)), "{body}: {pointer} is not named in {said}");
        }
        count += 1;
    }
    assert!(count >= 30);
    let long = format!("{{\"name\": \"{}\"}}", "x".repeat(2 << 20));
    bench.send_text("POST", "/assets", &[], &long).await.expect_problem(413);
    let large = format!("{{\"name\": \"{}\"}}", "x".repeat(900_000));
    assert_eq!(bench.send_text("POST", "/assets", &[], &large).await.status, 201, "this core has no limit");
    for header in ["if-match: 3", "if-match: \"x\"", "idempotency-key: 5"] {
        let path = format!("/nodes/{NODE}");
        bench.send("PUT", &path, &[header], &node()).await.expect_problem(400);
    }
    let foreign = ["origin: http://evil.example"];
    bench.send("POST", "/nodes", &foreign, &node()).await.expect_problem(403);
    assert_eq!(bench.end().await.state.revision, 1, "nothing but the one object was stored");
}

fn put_asset(number: u128, base: Option<u64>, name: &str) -> Edit {
    let asset = Asset { id: AssetId(Uuid::from_u128(1)), name: name.to_owned(), tags: Default::default() };
    let changes = vec![Change::Put { base: base.map(Revision), object: Object::Asset(asset) }];
    Edit { id: EditId(Uuid::from_u128(number)), changes }
}

async fn outcome(client: &mut TestSocket, id: EditId) -> EditOutcome {
    client
        .find(|event| match event {
            Event::EditDone(done) if done.id == id => Some(done.outcome.clone()),
            _ => None,
        })
        .await
}

#[tokio::test]
async fn an_edit_reaches_all_clients_and_its_answer_the_one_that_made_it() {
    let bench = Bench::start().await;
    let (mut one, mut other) = (bench.gateway.client(5).await, bench.gateway.client(6).await);
    let mut replica = whole(&mut other).await;
    let edit = put_asset(1, None, "Pump");
    one.send(&ClientMessage::Edit(edit.clone())).await;
    let done = outcome(&mut one, edit.id).await;
    assert!(matches!(done, EditOutcome::Applied { revision: 1, .. }), "{done:?}");
    let changed = other
        .find(|event| match event {
            Event::SiteChanged(changed) => Some(changed.clone()),
            _ => None,
        })
        .await;
    assert_eq!((changed.by, &changed.edit), (Some(client_id(5)), &edit));
    assert!(replica.apply(&changed));
    // A client that connects later gets the whole, and another one that asks for it too.
    let mut late = bench.gateway.client(7).await;
    assert_eq!(whole(&mut late).await, replica);
    other.send(&ClientMessage::RequestSite).await;
    assert_eq!(whole(&mut other).await, replica);
    let conflict = put_asset(2, None, "Fan");
    one.send(&ClientMessage::Edit(conflict.clone())).await;
    let object = ObjectId::Asset(AssetId(Uuid::from_u128(1)));
    let expected = vec![EditError::Conflict { object, revision: Some(Revision(1)) }];
    assert_eq!(outcome(&mut one, conflict.id).await, EditOutcome::Refused(EditRefusal::Invalid(expected)));
    bench.end().await;
}

#[tokio::test]
async fn edits_that_the_core_has_not_answered_when_it_is_lost_can_be_sent_again() {
    let gateway = Gateway::start().await;
    let mut core = gateway.core().await;
    let mut client = gateway.client(5).await;
    let edit = put_asset(1, None, "Pump");
    client.send(&ClientMessage::Edit(edit.clone())).await;
    while !matches!(core.receive().await, GatewayMessage::Edit { .. }) {}
    drop(core);
    let lost = outcome(&mut client, edit.id).await;
    assert!(matches!(lost, EditOutcome::Refused(EditRefusal::Unavailable(_))), "{lost:?}");
    gateway.get("/api/v1/site", &[]).await.expect_problem(503);
    // The next core has it, and a change of a revision that the gateway does not know.
    let mut core = gateway.core().await;
    let mut site = Site::default();
    site.apply(&mut core, None, edit.clone()).await;
    while core.receive().await != GatewayMessage::RequestSite {}
    site.send_whole(&mut core).await;
    assert_eq!(whole(&mut client).await, site.state);
    gateway.stop().await;
}
