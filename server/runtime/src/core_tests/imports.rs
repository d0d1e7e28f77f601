//! The whole path of an import: from a client's command to the importer, and back.

use super::*;
use site_model::SceneChange;
use std::path::PathBuf;

/// Reads the file "Endless" until it is cancelled, and fails on every other file.
struct FakeImporter;

impl MapImporter for FakeImporter {
    fn import(
        &self,
        file: &Path,
        name: &str,
        frame: Option<&Path>,
        _out: &Path,
        progress: &mut dyn FnMut(ImportStage, f32) -> ControlFlow<()>,
    ) -> Result<(), String> {
        assert!(file.exists() && frame.is_none_or(Path::exists));
        if name == "Endless" {
            while progress(ImportStage::ComputingViewpoints, 0.5).is_continue() {
                thread::yield_now();
            }
            return Err("It was cancelled.".to_owned());
        }
        Err(format!("{name} is no cloud."))
    }

    fn align(
        &self,
        maps: [&Path; 2],
        pairs: &[[Vec3; 2]],
        name: &str,
        _out: &Path,
        _progress: &mut dyn FnMut(ImportStage, f32) -> ControlFlow<()>,
    ) -> Result<(), String> {
        assert!(maps.iter().all(|map| map.exists()));
        Err(format!("{name} cannot be aligned by {} pairs.", pairs.len()))
    }

    fn make_normal(
        &self,
        _map: &Path,
        _after: &[PathBuf],
        changes: &[SceneChange],
        name: &str,
        _out: &Path,
        _progress: &mut dyn FnMut(ImportStage, f32) -> ControlFlow<()>,
    ) -> Result<(), String> {
        Err(format!("{name} cannot be made of {} changes.", changes.len()))
    }
}

#[test]
fn imports_run_one_at_a_time_can_be_cancelled_and_report_why_they_fail() {
    let bench = bench_of(usize::MAX, None, Some(Box::new(FakeImporter)));
    bench.clock(0);
    let mut gateway = bench.gateway();
    let uploads = bench.socket.parent().and_then(Path::parent).expect("a folder").join("uploads");
    let [first, second, missing] = [1, 2, 3].map(|number| UploadId(Uuid::from_u128(number)));
    for upload in [first, second] {
        std::fs::write(uploads.join(upload.to_string()), "points").expect("written");
    }
    let import = |upload, name: &str| api::Command::ImportMap { upload, name: name.to_owned(), frame: None };
    let failed = |gateway: &mut FakeGateway| {
        gateway.event(|_, event| match event {
            Event::Import(Import::Failed { upload, reason, .. }) => Some((*upload, reason.clone())),
            _ => None,
        })
    };
    gateway.command(1, import(first, "Endless"));
    gateway.event(|_, event| {
        let computes =
            matches!(event, Event::Import(Import::Running { stage: ImportStage::ComputingViewpoints, .. }));
        computes.then_some(())
    });
    gateway.command(2, api::Command::CancelImport(first));
    assert_eq!(failed(&mut gateway), (first, "It was cancelled.".to_owned()));
    gateway.command(3, import(second, " Se\u{7}cond  "));
    assert_eq!(failed(&mut gateway), (second, "Second is no cloud.".to_owned()));
    gateway.command(4, import(missing, "Missing"));
    assert_eq!(failed(&mut gateway).0, missing);
    std::fs::write(uploads.join(missing.to_string()), "points").expect("written");
    let frame = Some(MapId(Uuid::from_u128(9)));
    gateway.command(5, api::Command::ImportMap { upload: missing, name: "Aligned".to_owned(), frame });
    let gone = "The map whose frame it was to have is not here any more.".to_owned();
    assert_eq!(failed(&mut gateway), (missing, gone));
    let [map, onto] = [7, 8].map(|number| MapId(Uuid::from_u128(number)));
    let work = UploadId(Uuid::from_u128(4));
    let align = |pairs| api::Command::AlignMap { upload: work, name: "Aligned".to_owned(), map, onto, pairs };
    let data = uploads.parent().expect("a folder").join("maps");
    gateway.command(6, align(Vec::new()));
    assert_eq!(failed(&mut gateway), (work, "The map to be aligned is not here any more.".to_owned()));
    for map in [map, onto] {
        std::fs::create_dir_all(data.join(map.to_string())).expect("made");
    }
    gateway.command(7, align(vec![[Vec3::default(); 2]; 3]));
    assert_eq!(failed(&mut gateway), (work, "Aligned cannot be aligned by 3 pairs.".to_owned()));
    gateway.command(8, align(vec![[Vec3::default(); 2]; api::MAX_PAIRS + 9]));
    assert_eq!(failed(&mut gateway).1, format!("Aligned cannot be aligned by {} pairs.", api::MAX_PAIRS));
    let entry = audit_entry(&mut gateway, "import map Second");
    assert_eq!(entry.outcome, "failed: Second is no cloud.");
    assert!(entry.origin.is_some_and(|origin| origin.contains(&CLIENT.to_string())), "who has started it");
    // The file of the cancelled import is gone; of the others each is kept with its note.
    let kept = |upload: UploadId| uploads.join(upload.to_string()).exists();
    assert_eq!((kept(first), kept(second), kept(missing)), (false, true, true));
    assert_eq!(std::fs::read_dir(&uploads).expect("readable").count(), 4);
    let stored = gateway_snapshot_of_uploads(&bench);
    let problems: Vec<_> = stored.iter().map(|upload| (upload.upload, upload.problem.as_deref())).collect();
    assert!(problems.contains(&(second, Some("Second is no cloud."))), "{stored:?}");
}

fn gateway_snapshot_of_uploads(bench: &Bench) -> Vec<api::StoredUpload> {
    bench.gateway().event(|_, event| match event {
        Event::Uploads(uploads) => Some(uploads.clone()),
        _ => None,
    })
}

#[test]
fn a_core_without_an_importer_refuses_imports() {
    let bench = bench(usize::MAX);
    bench.clock(0);
    let mut gateway = bench.gateway();
    let upload = UploadId(Uuid::from_u128(1));
    gateway.command(1, api::Command::ImportMap { upload, name: String::new(), frame: None });
    let refused = gateway.event(|_, event| match event {
        Event::CommandDone { outcome, .. } => Some(matches!(outcome, CommandOutcome::Refused(_))),
        _ => None,
    });
    assert!(refused);
}

/// Waits for the entry of the audit log with this command.
pub(super) fn audit_entry(gateway: &mut FakeGateway, command: &str) -> api::StoredAudit {
    let end = Instant::now() + Duration::from_secs(30);
    for number in 0.. {
        assert!(Instant::now() < end, "no entry says {command:?}");
        let query = api::Query::Audit { before: None, containing: command.to_owned(), limit: 10 };
        gateway.send(&GatewayMessage::Query { number, by: CLIENT.into(), query });
        let found = loop {
            if let CoreMessage::Reply { result: Ok(api::QueryReply::Audit(entries)), .. } =
                gateway.next().expect("the core goes on")
            {
                break entries.into_iter().find(|entry| entry.command == command);
            }
        };
        if let Some(entry) = found {
            return entry;
        }
    }
    unreachable!("the loop ends by one of the above")
}

#[test]
fn what_the_gateway_has_refused_and_edits_that_do_not_fit_are_entries_of_the_audit_log() {
    let bench = bench(usize::MAX);
    bench.clock(0);
    let mut gateway = bench.gateway();
    let note = api::AuditNote {
        by: api::Caller { address: Some([192, 0, 2, 7].into()), ..CLIENT.into() },
        request: "GET /api/v1/audit".to_owned(),
        refused: Some("Ask an admin.".to_owned()),
        count: 40,
    };
    gateway.send(&GatewayMessage::Audit(vec![note]));
    let entry = audit_entry(&mut gateway, "GET /api/v1/audit");
    assert_eq!(entry.outcome, "refused: Ask an admin. (40 times)");
    assert!(entry.origin.is_some_and(|origin| origin.contains("192.0.2.7")), "from where");
    let edit = site_model::Edit { id: site_model::EditId(Uuid::from_u128(1)), changes: Vec::new() };
    gateway.send(&GatewayMessage::Edit { by: CLIENT.into(), edit });
    let entry = audit_entry(&mut gateway, "edit");
    assert!(entry.outcome.starts_with("refused: ") && entry.origin.is_some(), "{entry:?}");
}
