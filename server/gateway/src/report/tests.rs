//! Reports are written from a core that answers from lists, and read as text.

use super::context::ReportContext;
use super::period_report::write_period_report;
use super::rows::RunRow;
use super::run_report::write_run_report;
use crate::runs::CoreQueries;
use api::{Query, QueryReply, SiteState, StoredResult, StoredRun, StoredStep};
use serde_json::{Value, json};
use site_model::{Change, Edit, EditId, MissionId, Object, RunId, Utc};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tempfile::TempDir;
use uuid::Uuid;
use vocab::Stamp;

/// 24 November 2026, 11:00 UTC.
const BEGAN_NS: i64 = 1_795_518_000_000_000_000;
const MINUTE_NS: i64 = 60_000_000_000;
const HOSTILE: &str = "<script>\"x\"</script>'&";

fn id(number: u128) -> String {
    Uuid::from_u128(number).to_string()
}

fn run_id(number: u128) -> RunId {
    RunId(Uuid::from_u128(number))
}

fn at(minutes: i64) -> Stamp {
    Stamp::from_nanos(BEGAN_NS + minutes * MINUTE_NS)
}

/// Answers in pages of this length.
struct FakeCore {
    page: usize,
    steps: Vec<(RunId, StoredStep)>,
    results: Vec<StoredResult>,
}

impl CoreQueries for FakeCore {
    fn ask(&self, query: Query) -> io::Result<QueryReply> {
        Ok(match query {
            Query::Steps { run, after, .. } => {
                let of_run = self.steps.iter().filter(|(of, _)| *of == run).map(|(_, step)| step);
                let rest = of_run.filter(|step| after.is_none_or(|after| (step.step, step.attempt) > after));
                QueryReply::Steps(rest.take(self.page).cloned().collect())
            }
            Query::Results { run, after, .. } => {
                let of_run = self.results.iter().filter(|result| result.run == run);
                let rest = of_run.filter(|result| after.is_none_or(|after| result.number > after));
                QueryReply::Results(rest.take(self.page).cloned().collect())
            }
            Query::PointResults { before, .. } => {
                let earlier =
                    self.results.iter().rev().find(|it| before.is_none_or(|before| it.number < before));
                QueryReply::Results(earlier.into_iter().cloned().collect())
            }
            other => return Err(io::Error::other(format!("not asked by a report: {other:?}"))),
        })
    }
}

/// A site, a core and files, from which reports are made.
struct Scene {
    objects: Vec<Value>,
    runs: Vec<StoredRun>,
    core: FakeCore,
    data: TempDir,
}

impl Scene {
    /// A site in London with a mission of three tasks at two nodes and an inspection point, and no runs.
    fn new() -> Self {
        let pose = json!({ "position": { "x": 6.0, "y": 1.0, "z": 0.0 }, "orientation": { "w": 1.0, "x": 0.0, "y": 0.0, "z": 0.0 } });
        let node = |number: u128, name: &str| json!({ "node": { "id": id(number), "name": name, "kind": "inspection", "map_from_node": pose } });
        let at_node = |node: u128| json!({ "node": { "node": id(node), "request": { "action": "photo" } } });
        let objects = vec![
            json!({ "settings": { "name": "Works 3", "time_zone": "Europe/London" } }),
            node(21, "Pump 7"),
            node(22, "Tank"),
            json!({ "inspection_point": { "id": id(31), "name": "Gauge east", "node": id(22), "target_m": { "x": 9.0, "y": 9.0, "z": 1.0 },
                "request": { "action": "temperature_humidity" }, "limits": { "min": 10.0, "max": 30.0, "unit": "°C" } } }),
            json!({ "mission": { "id": id(2), "name": "Morning round", "tasks": [
                { "id": id(41), "place": at_node(21) },
                { "id": id(42), "place": { "inspection_point": id(31) } },
                { "id": id(43), "place": at_node(22) } ] } }),
        ];
        let core = FakeCore { page: 100, steps: Vec::new(), results: Vec::new() };
        Self { objects, runs: Vec::new(), core, data: tempfile::tempdir().unwrap() }
    }

    /// With a run of this number that has ended after 12 minutes.
    fn run(mut self, number: u128, state: &str) -> Self {
        let body = json!({ "cause": { "account": { "command": id(9), "account": "anna" } }, "began": BEGAN_NS, "tasks": 3 }).to_string();
        self.runs.push(StoredRun {
            run: run_id(number),
            mission: MissionId(Uuid::from_u128(2)),
            state: state.into(),
            is_ended: true,
            body,
            began: at(-1),
            changed: at(12),
        });
        self
    }

    /// With an attempt of a task of the last run, that was intended after this number of minutes and took 42 s.
    fn step(mut self, step: u32, attempt: u32, state: &str, minute: i64, details: Value) -> Self {
        let run = self.runs.last().unwrap().run;
        let intended = at(minute);
        let is_done = !matches!(state, "retriable" | "running");
        let done = is_done.then(|| Stamp::from_nanos(intended.nanos() + 42_000_000_000));
        let (state, body) = (state.into(), details.to_string());
        self.core.steps.push((run, StoredStep { step, attempt, state, body, intended, done }));
        self
    }

    /// With a result of the last run.
    fn result(mut self, step: u32, attempt: u32, details: Value) -> Self {
        let number = self.core.results.len() as u64 + 1;
        let run = self.runs.last().unwrap().run;
        let (kind, body) = ("photo".into(), details.to_string());
        self.core.results.push(StoredResult {
            number,
            run,
            step,
            attempt,
            kind,
            blob: None,
            body,
            comparison: None,
            at: at(5),
        });
        self
    }

    fn object(mut self, object: Value) -> Self {
        self.objects.push(object);
        self
    }

    /// Stores a file whose name is 64 times this digit, and says what a result has of it.
    fn file(&self, digit: char, name: &str, media_type: &str, content: &[u8]) -> Value {
        let path = self.blob(digit);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, content).unwrap();
        file(digit, name, media_type)
    }

    fn blob(&self, digit: char) -> PathBuf {
        let hash = digit.to_string().repeat(64);
        self.data.path().join("blobs").join(&hash[..2]).join(hash)
    }

    fn context(&self) -> ReportContext {
        let changes = self.objects.iter().map(|object| {
            let object: Object = serde_json::from_value(object.clone()).unwrap();
            Change::Put { base: None, object }
        });
        let edit = Edit { id: EditId(Uuid::from_u128(4)), changes: changes.collect() };
        let mut state = SiteState { revision: 17, ..SiteState::default() };
        state.site.apply(&edit, edit.id).unwrap();
        ReportContext::new(Arc::new(state), self.data.path(), Utc(BEGAN_NS + 60 * MINUTE_NS))
    }

    /// The report of the last run.
    fn report(&self) -> String {
        let mut bytes = Vec::new();
        let run = RunRow::of(self.runs.last().unwrap());
        write_run_report(&self.context(), &self.core, run, &mut bytes).unwrap();
        String::from_utf8(bytes).unwrap()
    }

    /// The report of all runs.
    fn period(&self) -> String {
        let mut bytes = Vec::new();
        let runs = self.runs.iter().map(RunRow::of).collect();
        let span = [Utc(BEGAN_NS - 660 * MINUTE_NS), Utc(BEGAN_NS + 780 * MINUTE_NS)];
        write_period_report(&self.context(), &self.core, span, runs, &mut bytes).unwrap();
        String::from_utf8(bytes).unwrap()
    }
}

fn file(digit: char, name: &str, media_type: &str) -> Value {
    json!({ "name": name, "media_type": media_type, "blob": digit.to_string().repeat(64), "bytes": 84_211 })
}

/// Details of a result with these files and readings.
fn gathered(files: &[Value], readings: &[Value]) -> Value {
    json!({ "node": id(22), "inspection_point": id(31), "value": {
        "at": { "robot_time": 0, "utc_ns": 3, "is_synchronised": true }, "files": files, "readings": readings } })
}

fn celsius(value: f64) -> Value {
    json!({ "name": "temperature", "value": value, "standard_deviation": 0.05, "unit": "°C" })
}

fn of_task(task: u128, node: u128, action: &str, step: Value) -> Value {
    json!({ "task": id(task), "node": id(node), "action": action, "step": step })
}

fn done(task: u128, node: u128, action: &str) -> Value {
    of_task(task, node, action, json!("succeeded"))
}

/// The text of a document, without markup and styles.
fn text(report: &str) -> String {
    let body = report.split_once("<body>").unwrap().1;
    let mut text = String::new();
    for part in body.split('<').skip(1) {
        let (_, after) = part.split_once('>').unwrap();
        text.push(' ');
        text.push_str(after);
    }
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Fails unless the texts stand in the document in this order.
fn assert_order(text: &str, parts: &[&str]) {
    let mut rest = text;
    for part in parts {
        let found = rest.find(part);
        assert!(found.is_some(), "{part} is not behind the one before, in {text}");
        rest = &rest[found.unwrap() + part.len()..];
    }
}

#[test]
fn a_photo_that_has_changed_stands_beside_the_one_before_with_frames() {
    let mut scene = Scene::new().run(1, "succeeded");
    let photos = ['a', 'b'].map(|letter| scene.file(letter, "photo.jpg", "image/jpeg", JPEG));
    for (step, photo) in (0..).zip(photos) {
        let mut details = gathered(&[photo], &[]);
        details["inspection_point"] = json!(id(31));
        scene = scene.step(step, 1, "succeeded", 1, done(42, 22, "photo")).result(step, 1, details);
    }
    let comparison = |changes: Value| {
        let aligned = json!({ "after_from_before": [[1.0, 0.0, 10.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], "residual_px": 0.34,
            "before_size_px": [640, 480], "after_size_px": [640, 480], "changes": changes });
        Some(json!({ "before": 1, "outcome": { "aligned": aligned } }).to_string())
    };
    scene.core.results[1].comparison = comparison(json!([]));
    assert!(!scene.report().contains("differs"));
    let change = json!({ "min_px": [100, 50], "max_px": [119, 69], "area_px": 90, "strength": 0.8 });
    scene.core.results[1].comparison = comparison(json!([change]));
    let report = scene.report();
    assert_order(
        &report,
        &[
            "The photo differs from the one before in 1 place. Both are aligned within 0.3 px.",
            "Gauge east · before: ",
            "data:image/jpeg;base64,",
            "M94.5 44.5 H125.5 V75.5 H94.5 Z",
            "data:image/jpeg;base64,",
            "M104.0 44.0 H136.0 V76.0 H104.0 Z",
        ],
    );
}

const JPEG: &[u8] = b"\xff\xd8\xffphoto";

#[test]
fn a_report_says_what_a_run_was_then_what_needs_attention_then_each_task() {
    let scene = Scene::new().run(1, "partially_succeeded");
    let photo = scene.file('a', "photo.jpg", "image/jpeg", JPEG);
    let blocked = json!({ "failed": { "not_reached": "path_blocked" } });
    let scene = scene
        .step(0, 1, "succeeded", 1, done(41, 21, "photo"))
        .result(0, 1, gathered(&[photo], &[]))
        .step(1, 1, "succeeded", 4, done(42, 22, "temperature_humidity"))
        .result(1, 1, gathered(&[], &[celsius(41.234)]))
        .step(2, 1, "failed", 7, of_task(43, 22, "photo", blocked));
    let report = scene.report();
    assert!(report.starts_with("<!DOCTYPE html>") && report.ends_with("</html>\n"));
    assert!(report.contains("<title>Works 3: Morning round, 24 November 2026, 11:00</title>"), "{report}");
    assert!(report.contains("<img alt=\"photo.jpg of Pump 7\" src=\"data:image/jpeg;base64,/9j/cGhvdG8=\">"));
    let text = text(&report);
    let head = [
        "Works 3 · Report of a run",
        "Morning round",
        "Succeeded in part",
        "Began 24 November 2026, 11:00 Ended 24 November 2026, 11:12 Duration 12 min 0 s",
        "Europe/London (UTC+00:00)",
        "Asked for by anna",
        "2 of 3 tasks done 1 failed 0 skipped 1 reading outside its limits 0 changes",
    ];
    let attention = [
        "What needs attention",
        "Gauge east Temperature 41.234 °C above 30 11:05",
        "Tank Photo Failed The path stayed blocked. 11:07",
    ];
    let tasks = [
        "Tasks 1 Pump 7 Done Photo · 11:01 · 42 s",
        "Pump 7 · 24 Nov, 11:05 · photo.jpg",
        "2 Gauge east Done Temp. and humidity · 11:04 · 42 s",
        "Temperature 41.234 ± 0.050 °C 10 to 30 above 30",
        "3 Tank Failed Photo · 11:07 · 42 s The path stayed blocked.",
    ];
    let foot = ["Revision of the site 17", "Report made 24 November 2026, 12:00, Europe/London"];
    let (run, mission) = (format!("Run {}", id(1)), format!("Mission {}", id(2)));
    let ids = [run.as_str(), mission.as_str()];
    assert_order(&text, &[&head[..], &attention, &tasks, &ids, &foot].concat());
}

#[test]
fn nothing_from_people_robots_or_files_becomes_markup() {
    let hostile_failure = json!({ "failed": { "action_failed": HOSTILE } });
    let reading = json!({ "name": HOSTILE, "value": 50.0, "unit": "°C" });
    let odd_unit = json!({ "name": "dose", "value": 1.0, "unit": HOSTILE });
    let change = json!({ "scene_change": {
        "id": id(51), "map": id(6), "kind": "appeared", "points": 9, "confidence": 0.9, "before": { "map": id(6) }, "after": id(1),
        "place": { "centre_m": { "x": 6.0, "y": 2.0, "z": 0.5 }, "size_m": [0.6, 0.4, 1.0], "yaw_rad": 0.0 },
        "first_seen": 1, "last_seen": 2, "times_seen": 1, "review": { "dismissed": { "reason": HOSTILE } }, "comment": HOSTILE } });
    let mut scene = Scene::new().object(change).run(1, HOSTILE);
    for object in &mut scene.objects {
        for kind in ["settings", "node", "inspection_point", "mission"] {
            if let Some(named) = object.get_mut(kind) {
                named["name"] = json!(HOSTILE);
            }
        }
    }
    let photo = scene.file('a', HOSTILE, "image/jpeg", JPEG);
    let missing = file('b', HOSTILE, HOSTILE);
    let scene = scene
        .step(0, 1, "failed", 1, of_task(41, 21, HOSTILE, hostile_failure))
        .result(0, 1, gathered(&[photo, missing], &[reading, odd_unit]))
        .step(1, 1, "skipped", 2, of_task(42, 22, HOSTILE, json!("skipped")))
        .result(1, 1, json!({ "value": HOSTILE }))
        .step(2, 1, HOSTILE, 3, json!({ "place": { "zone": id(77) }, "action": HOSTILE }));
    for report in [scene.report(), scene.period()] {
        assert!(
            report.matches("&lt;script&gt;&quot;x&quot;&lt;/script&gt;&#39;&amp;").count() >= 8,
            "{report}"
        );
        let body = report.split_once("<body>").unwrap().1;
        let allowed = [
            "header",
            "p",
            "h1",
            "h2",
            "h3",
            "h4",
            "dl",
            "div",
            "dt",
            "dd",
            "ul",
            "li",
            "strong",
            "span",
            "table",
            "thead",
            "tbody",
            "tr",
            "th",
            "td",
            "article",
            "section",
            "figure",
            "figcaption",
            "img",
            "footer",
            "body",
            "html",
            "a",
        ];
        for tag in body.split('<').skip(1) {
            let name = tag.trim_start_matches('/');
            let name = &name[..name.find(|c: char| !c.is_ascii_alphanumeric()).unwrap()];
            assert!(allowed.contains(&name), "{tag}");
            // A quote of a name would end an attribute.
            assert_eq!(tag.split('>').next().unwrap().matches('"').count() % 2, 0, "{tag}");
        }
    }
}

#[test]
fn nothing_is_loaded_from_elsewhere_and_nothing_runs() {
    let report = Scene::new().run(1, "succeeded").report();
    let policy = "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src &#39;none&#39;; img-src data:; style-src &#39;unsafe-inline&#39;;";
    assert_order(&report, &[policy, "<style>"]);
    for outside in ["http:", "https:", "//", "url(", "@import", "<script", "<link", "javascript"] {
        assert!(!report.contains(outside), "{outside}");
    }
}

#[test]
fn files_that_cannot_be_shown_are_named() {
    let scene = Scene::new().run(1, "succeeded").step(0, 1, "succeeded", 1, done(41, 21, "photo"));
    let files = [
        file('0', "gone.jpg", "image/jpeg"),
        scene.file('1', "large.jpg", "image/jpeg", JPEG),
        scene.file('2', "page.jpg", "image/jpeg", b"<svg onload='x'/>"),
        scene.file('3', "temperatures_centikelvin.png", "image/png", b"\x89PNG\r\n\x1a\nrest"),
        scene.file('4', "thermal.png", "image/png", b"\x89PNG\r\n\x1a\nrest"),
        scene.file('5', "cloud.pcd", "application/vnd.pcd", b"# .PCD"),
        scene.file('6', "spectrum.json", "application/json", b"{\"live_time_s\": 60}"),
    ];
    std::fs::File::options().write(true).open(scene.blob('1')).unwrap().set_len((16 << 20) + 1).unwrap();
    let scene = scene.result(0, 1, gathered(&files, &[]));
    let report = scene.report();
    assert_eq!(report.matches("<img ").count(), 1, "only the thermal picture");
    assert!(report.contains("src=\"data:image/png;base64,iVBORw0KGgpyZXN0\""));
    let text = text(&report);
    let named = [
        "gone.jpg · 85 kB · not on the robot's disk any more".replace('\'', "&#39;"),
        "large.jpg · 85 kB · larger than 16 MB, so it is not shown here".to_owned(),
        "page.jpg · 85 kB · neither JPEG nor PNG, so it is not shown here".to_owned(),
        "temperatures_centikelvin.png · 85 kB cloud.pcd · 85 kB spectrum.json · 85 kB".to_owned(),
    ];
    assert_order(&text, &named.each_ref().map(String::as_str));
    std::fs::File::options().write(true).open(scene.blob('1')).unwrap().set_len(16 << 20).unwrap();
    assert_eq!(scene.report().matches("<img ").count(), 2, "exactly as long as allowed");
}

#[test]
fn a_spectrum_is_a_plot_with_its_axes() {
    let scene = Scene::new().run(1, "succeeded").step(0, 1, "succeeded", 1, done(41, 21, "gamma_spectrum"));
    let counts: Vec<u32> = (0..1_024).map(|channel| if channel == 220 { 900 } else { 10 }).collect();
    let spectrum =
        json!({ "live_time_s": 60.0, "first_kev": 0.0, "channel_kev": 3.0, "counts": counts }).to_string();
    let spectrum = scene.file('6', "spectrum.json", "application/json", spectrum.as_bytes());
    let report = scene.result(0, 1, gathered(&[spectrum], &[])).report();
    assert!(report.contains("aria-label=\"Gamma spectrum of Pump 7\""));
    let text = text(&report);
    assert_order(&text, &["1 10 100 1 000 0 500", "2500 3000", "Energy, keV", "Counts in a channel"]);
    assert!(text.contains("11 130 counts in 60 s live time"), "{text}");
}

#[test]
fn runs_without_tasks_say_why() {
    let scene = Scene::new().run(1, "cancelled");
    let report = text(&scene.report());
    assert_order(
        &report,
        &[
            "Cancelled by a person",
            "0 of 3 tasks done",
            "3 not done",
            "Nothing. No task",
            "It ended before its first task.",
        ],
    );
    let mut scene = Scene::new().run(1, "queued");
    scene.runs[0] = StoredRun { is_ended: false, body: "no JSON".into(), ..scene.runs[0].clone() };
    let report = text(&scene.report());
    let queued = [
        "Waits for its turn",
        "Began Not yet Ended Not yet",
        "not known",
        "0 of 0 tasks",
        "It has not begun.",
    ];
    assert_order(&report, &queued);
    assert!(!report.contains("Duration"));
}

#[test]
fn every_attempt_is_listed_with_its_reason_and_its_results_in_whatever_order_they_came() {
    let failed = |kind: &str| json!({ kind: { "action_failed": "No answer." } });
    let value = |text: &str| json!({ "value": text });
    let mut scene = Scene::new()
        .run(1, "succeeded")
        .step(0, 1, "retriable", 1, of_task(41, 21, "photo", failed("tries_later")))
        .step(0, 2, "succeeded", 9, done(41, 21, "photo"))
        .step(1, 1, "succeeded", 3, done(42, 22, "photo"))
        .step(2, 1, "retriable", 4, of_task(43, 22, "photo", json!({ "asks": "action_timed_out" })))
        .step(2, 2, "skipped", 5, of_task(43, 22, "photo", json!("skipped")))
        .result(1, 1, value("second"))
        .result(2, 1, value("third"))
        .result(0, 2, value("first"))
        .result(1, 1, value("second again"));
    let whole = scene.report();
    assert_order(
        &text(&whole),
        &[
            "Tank Photo Skipped The action did not end in its time. A person left it out",
            "Tasks 1 Pump 7 Done Photo · 11:09 · 42 s · 2 attempts",
            "1 Failed, to be tried again 11:01 No answer. 2 Done 11:09 42 s first",
            "2 Gauge east Done Photo · 11:03 · 42 s second second again",
            "3 Tank Skipped Photo · 11:05 · 42 s · 2 attempts",
            "third",
        ],
    );
    for page in [1, 2] {
        scene.core.page = page;
        assert!(scene.report() == whole, "pages of {page} make another report");
    }
}

#[test]
fn readings_are_judged_by_limits_of_their_unit_only() {
    let humidity = json!({ "name": "relative_humidity", "value": 90.0, "unit": "%" });
    let readings = [celsius(9.5), celsius(30.0), humidity];
    let scene = Scene::new()
        .run(1, "succeeded")
        .step(1, 1, "succeeded", 1, done(42, 22, "temperature_humidity"))
        .result(1, 1, gathered(&[], &readings));
    let report = scene.report();
    assert_order(
        &text(&report),
        &[
            "1 reading outside its limits",
            "Gauge east Temperature 9.500 °C below 10",
            "Temperature 9.500 ± 0.050 °C 10 to 30 below 10",
            "Temperature 30.000 ± 0.050 °C 10 to 30 within limits",
            "Relative humidity 90.00 % Run",
        ],
    );
    assert!(report.contains("<span class=\"alert\">below 10</span>"));
}

#[test]
fn a_gauge_that_was_not_read_needs_attention() {
    let problem = "The needle is hidden by <glare>.";
    let mut details = gathered(&[], &[]);
    details["value"]["gauge"] = json!({ "problem": problem });
    let mut read = gathered(&[], &[celsius(20.0)]);
    read["value"]["gauge"] = json!({ "needle_px": [[1.0, 2.0], [3.0, 4.0]] });
    let scene =
        Scene::new().run(1, "succeeded").step(1, 1, "succeeded", 1, done(42, 22, "photo")).result(1, 1, read);
    assert!(text(&scene.report()).contains("Nothing. No task"));
    let report = scene.result(1, 1, details).report();
    let row =
        "Gauges that were not read Place Reason Time Gauge east The needle is hidden by &lt;glare&gt;. 11:05";
    assert_order(&text(&report), &[row, "2 Gauge east Done", "The needle is hidden by &lt;glare&gt;."]);
}

#[test]
fn changes_of_the_scene_are_those_that_this_run_has_found() {
    let change = |number: u128, after: u128, kind: Value, x: f64| {
        json!({ "scene_change": {
            "id": id(number), "map": id(6), "kind": kind, "points": 9, "confidence": 0.9, "before": { "map": id(6) }, "after": id(after),
            "place": { "centre_m": { "x": x, "y": 2.0, "z": 0.5 }, "size_m": [0.6, 0.4, 1.04], "yaw_rad": 0.0 },
            "first_seen": 1, "last_seen": 2, "times_seen": 1, "review": "acknowledged" } })
    };
    let from = json!({ "moved": { "from": { "centre_m": { "x": 60.0, "y": 3.5, "z": 0.5 }, "size_m": [0.6, 0.4, 1.0], "yaw_rad": 0.0 } } });
    let turned = json!({ "moved": { "from": { "centre_m": { "x": 60.0, "y": 2.0, "z": 0.5 }, "size_m": [0.6, 0.4, 1.0], "yaw_rad": 2.55 } } });
    let scene = Scene::new()
        .object(change(51, 1, json!("appeared"), 6.4))
        .object(change(52, 1, from, 60.0))
        .object(change(54, 1, turned, 60.0))
        .object(change(53, 8, json!("removed"), 6.0))
        .run(1, "succeeded");
    let text = text(&scene.report());
    assert_order(
        &text,
        &[
            "3 changes of the scene",
            "Appeared 0.6 × 0.4 × 1.0 m near Pump 7 (x 6.4 m, y 2.0 m) acknowledged",
            "Moved by 1.5 m 0.6 × 0.4 × 1.0 m x 60.0 m, y 2.0 m acknowledged",
            "Turned by 34° 0.6 × 0.4 × 1.0 m x 60.0 m, y 2.0 m acknowledged",
        ],
    );
    assert!(!text.contains("Removed"), "found by another run");
}

#[test]
fn actions_on_the_way_are_listed_and_count_as_no_tasks() {
    let edge = json!({ "edge": { "id": id(61), "from": id(21), "to": id(22), "traversal": "walk", "is_enabled": true } });
    let place = json!({ "edge": { "edge": id(61), "stage": "enter", "index": 0 } });
    let failed = json!({ "place": place, "action": "open_door", "step": { "failed": { "action_failed": "It stayed shut." } } });
    let scene = Scene::new()
        .object(edge)
        .run(1, "partially_succeeded")
        .step(0, 1, "succeeded", 1, done(41, 21, "photo"))
        .step(3, 1, "failed", 2, failed);
    let text = text(&scene.report());
    let row = "Pump 7 to Tank, at its beginning open_door Failed It stayed shut.";
    assert_order(&text, &["1 of 3 tasks done 0 failed", row, "4 Pump 7 to Tank, at its beginning Failed"]);
}

#[test]
fn a_report_of_a_time_sums_up_all_runs_and_shows_pictures_of_what_needs_attention_only() {
    let scene = Scene::new();
    let [good, bad, near] = ['a', 'b', 'c']
        .map(|digit| scene.file(digit, "photo.jpg", "image/jpeg", &[JPEG, &[digit as u8]].concat()));
    let at_pump = |photo: &Value| json!({ "node": id(21), "value": gathered(std::slice::from_ref(photo), &[])["value"] });
    let scene = scene
        .run(1, "succeeded")
        .step(0, 1, "succeeded", 1, done(41, 21, "photo"))
        .result(0, 1, at_pump(&good))
        .run(3, "partially_succeeded")
        .step(0, 1, "succeeded", 2, done(41, 21, "photo"))
        .result(0, 1, at_pump(&good))
        .step(1, 1, "succeeded", 3, done(42, 22, "temperature_humidity"))
        .result(1, 1, gathered(&[bad], &[celsius(50.0)]))
        .step(2, 1, "succeeded", 4, done(43, 22, "photo"))
        .result(2, 1, json!({ "node": id(22), "value": gathered(&[near], &[])["value"] }));
    let report = scene.period();
    let shown: Vec<&str> = report.split("data:image/jpeg;base64,").skip(1).map(|rest| &rest[..12]).collect();
    assert_eq!(shown, ["/9j/cGhvdG9i", "/9j/cGhvdG9j"], "the reading's own, and that of its node");
    for number in ["0", "1"] {
        assert!(report.contains(&format!("<section class=\"run\" id=\"run-{number}\">")));
        assert!(report.contains(&format!("<a href=\"#run-{number}\">24 Nov, 11:00</a>")));
    }
    assert_order(
        &text(&report),
        &[
            "Works 3 · Report of all runs 24 November 2026 From 24 November 2026, 00:00 To 25 November 2026, 00:00",
            "2 runs 4 of 6 tasks done 0 failed 0 skipped 1 reading outside",
            "24 Nov, 11:00 Morning round Succeeded 1 of 3 0",
            "24 Nov, 11:00 Morning round Succeeded in part 3 of 3 1",
            "What needs attention",
            "24 Nov, 11:00 Gauge east Temperature 50.000 °C above 30",
            "Morning round, 24 Nov, 11:00 Succeeded",
            "1 Pump 7 Done",
            "photo.jpg · 85 kB",
            "Morning round, 24 Nov, 11:00 Succeeded in part",
        ],
    );
    assert!(text(&Scene::new().period()).contains("No run was asked for in this time."));
}

#[test]
fn long_lists_are_cut_and_say_how_much_is_missing() {
    let readings = vec![celsius(50.0); 130];
    let scene = Scene::new()
        .run(1, "succeeded")
        .step(1, 1, "succeeded", 1, done(42, 22, "temperature_humidity"))
        .result(1, 1, gathered(&[], &readings));
    let text = text(&scene.report());
    let attention = &text[..text.find(" Tasks ").unwrap()];
    assert_eq!(attention.matches("above 30").count(), 100);
    assert_order(&text, &["130 readings outside", "And 30 more.", "Tasks"]);
}

#[test]
fn a_core_that_fails_ends_the_report_with_an_error() {
    struct Silent;
    impl CoreQueries for Silent {
        fn ask(&self, _: Query) -> io::Result<QueryReply> {
            Err(io::Error::other("gone"))
        }
    }
    let scene = Scene::new().run(1, "succeeded");
    let run = || RunRow::of(&scene.runs[0]);
    assert!(write_run_report(&scene.context(), &Silent, run(), Vec::new()).is_err());
    assert!(
        write_period_report(&scene.context(), &Silent, [Utc(0), Utc(1)], vec![run()], Vec::new()).is_err()
    );
}

#[test]
fn an_unknown_time_zone_counts_as_utc() {
    let mut scene = Scene::new().run(1, "succeeded");
    scene.objects[0] = json!({ "settings": { "name": "", "time_zone": "Mars/Base" } });
    assert_order(&text(&scene.report()), &["Site · Report of a run", "UTC (UTC+00:00)"]);
    let summer = Stamp::from_nanos(BEGAN_NS - 120 * 24 * 60 * MINUTE_NS);
    let context = Scene::new().context();
    assert_eq!(context.zone_at(Utc(summer.nanos())), "Europe/London (UTC+01:00)");
    assert!(Path::new(context.data_dir()).is_absolute());
}

#[test]
fn alerts_that_are_not_closed_need_attention_the_worst_first() {
    let ended_ns = at(12).nanos();
    let alert = |number: u128, severity: &str, state: Value, first_raised: i64, work_order: &str| {
        json!({ "alert": {
            "id": id(number), "severity": severity, "state": state,
            "cause": { "outside_limits": { "point": id(31), "run": id(1), "result": 1,
                "reading": { "name": "temperature", "value": 41.234, "unit": "°C", "outside": { "above": 30.0 } } } },
            "owner": "Ada", "work_order": work_order, "first_raised": first_raised, "last_raised": at(5).nanos(), "times_raised": 2, "recovered": 7 } })
    };
    let closed = json!({ "closed": { "by": "Ada", "at": 1, "remark": "done" } });
    let acknowledged = json!({ "acknowledged": { "by": "Ada", "at": 1 } });
    let scene = Scene::new()
        .object(alert(51, "warning", json!("open"), 5, "Look at <it>"))
        .object(alert(52, "critical", acknowledged, ended_ns, "Replace it"))
        .object(alert(53, "critical", closed, 5, "Closed one"))
        .object(alert(54, "critical", json!("open"), ended_ns + 1, "Later one"))
        .run(1, "succeeded");
    let text = text(&scene.report());
    let what = "Gauge east Temperature 41.23 °C, above 30 24 Nov, 11:05, 2 times";
    assert_order(
        &text,
        &[
            "What needs attention Alerts that are not closed",
            &format!("Critical {what} acknowledged by Ada, normal again Ada Replace it"),
            &format!("Warning {what} open, normal again Ada Look at &lt;it&gt;"),
        ],
    );
    assert!(!text.contains("Closed one") && !text.contains("Later one"), "{text}");
}
