//! Journals: what is written comes back, and what happens to those that are cut or damaged.

use super::*;
use expect_test::{expect, expect_file};
use messages::{EdgeKind, GraphDelta, GraphEdge, GraphNode, LoopEvidence, LoopSource, LoopTask, LoopVerdict};
use std::fs;
use uuid::Uuid;
use vocab::{SessionId, Vec3};

fn pose(x: f64) -> Pose {
    Pose { position: Vec3::new(x, 0.0, 0.0), ..Pose::IDENTITY }
}

fn node(id: u32, x: f64) -> GraphNode {
    GraphNode { id: KeyframeId(id), stamp: Stamp::from_parts(i64::from(id), 0), map_from_keyframe: pose(x) }
}

fn edge(from: u32) -> GraphEdge {
    GraphEdge {
        from: KeyframeId(from),
        to: KeyframeId(from + 1),
        kind: EdgeKind::Odometry,
        from_from_to: pose(1.0),
        information: [[0.0; 6]; 6],
    }
}

fn delta(base_revision: u64, nodes: Vec<GraphNode>, edges: Vec<GraphEdge>) -> SessionRecord {
    SessionRecord::GraphDelta(Arc::new(GraphDelta {
        session: SessionId(Uuid::from_u128(1)),
        base_revision,
        revision: base_revision + 1,
        nodes,
        removed_loops: Vec::new(),
        edges,
    }))
}

/// One keyframe, a second one, and a closed loop that moves the second by half a metre.
fn records() -> Vec<SessionRecord> {
    let graph = PoseGraph { revision: 1, nodes: vec![node(0, 0.0)], edges: Vec::new() };
    let scan =
        |seconds, x| SessionRecord::ScanPose { stamp: Stamp::from_parts(seconds, 0), map_from_base: pose(x) };
    vec![
        SessionRecord::State { extends: None, distance_m: 1.5 },
        SessionRecord::Graph(Arc::new(graph)),
        scan(1, 0.1),
        delta(1, vec![node(1, 1.0)], vec![edge(0)]),
        scan(2, 1.2),
        delta(2, vec![node(1, 1.5)], Vec::new()),
    ]
}

fn write(path: &Path) -> Vec<u8> {
    let mut journal = SessionJournal::open(path.to_owned()).expect("opens");
    for record in records() {
        journal.append(&record).expect("written");
    }
    journal.sync().expect("synced");
    fs::read(path).expect("written")
}

fn read(path: &Path) -> RecoveredJournal {
    RecoveredJournal::read(path, ScanPoses::Wanted).expect("read")
}

#[test]
fn a_journal_holds_the_graph_and_a_trajectory_that_moves_with_it() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = dir.path().join("journal.bin");
    write(&path);
    let read = read(&path);
    assert_eq!((read.graph.revision, read.graph.edges.len(), read.damaged_at), (3, 1, None));
    assert_eq!(read.graph.nodes[1].map_from_keyframe, pose(1.5));
    assert_eq!((read.distance_m, read.last()), (1.5, Stamp::from_parts(2, 0)));
    let positions: Vec<f64> = read.trajectory().iter().map(|(_, pose)| pose.position.x).collect();
    assert!((positions[0] - 0.1).abs() < 1e-9 && (positions[1] - 1.7).abs() < 1e-9, "{positions:?}");
}

#[test]
fn a_session_without_a_scan_was_interrupted_at_its_last_keyframe() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = dir.path().join("journal.bin");
    let graph = PoseGraph { revision: 1, nodes: vec![node(0, 0.0), node(7, 0.0)], edges: Vec::new() };
    let mut journal = SessionJournal::open(path.clone()).expect("opens");
    journal.append(&SessionRecord::Graph(Arc::new(graph))).expect("written");
    assert_eq!(read(&path).last(), Stamp::from_parts(7, 0));
}

#[test]
fn a_journal_that_is_cut_anywhere_gives_what_was_whole() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = dir.path().join("journal.bin");
    let whole = write(&path);
    let mut last = 0;
    for length in HEADER_BYTES as usize..=whole.len() {
        fs::write(&path, &whole[..length]).expect("written");
        let read = read(&path);
        assert_eq!(read.damaged_at, None, "a torn record is no damage");
        assert!(read.graph.revision >= last);
        last = read.graph.revision;
    }
    assert_eq!(last, 3);
}

#[test]
fn a_wrong_bit_is_found_and_what_came_before_it_is_kept() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = dir.path().join("journal.bin");
    let whole = write(&path);
    for byte in HEADER_BYTES as usize..whole.len() {
        let mut damaged = whole.clone();
        damaged[byte] ^= 0x10;
        fs::write(&path, &damaged).expect("written");
        let read = read(&path);
        assert!(read.damaged_at.is_some_and(|offset| offset <= byte as u64), "byte {byte}");
        assert!(read.graph.revision < 3 || byte > whole.len() / 2);
    }
}

#[test]
fn changes_after_a_gap_wait_for_the_whole_graph() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = dir.path().join("journal.bin");
    write(&path);
    let mut journal = SessionJournal::open(path.clone()).expect("opens");
    journal.append(&delta(7, vec![node(2, 9.0)], Vec::new())).expect("written");
    let gap = read(&path);
    assert_eq!((gap.graph.revision, gap.damaged_at.is_some()), (3, true));
    let whole = PoseGraph {
        revision: 9,
        nodes: (0..4).map(|id| node(id, f64::from(id))).collect(),
        edges: Vec::new(),
    };
    journal.append(&SessionRecord::Graph(Arc::new(whole))).expect("written");
    let healed = read(&path);
    assert_eq!((healed.graph.nodes.len(), healed.damaged_at), (4, None));
}

#[test]
fn a_journal_of_a_later_program_is_not_read() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = dir.path().join("journal.bin");
    let mut bytes = write(&path);
    bytes[4] = 2;
    fs::write(&path, bytes).expect("written");
    let error = RecoveredJournal::read(&path, ScanPoses::Ignored).expect_err("refused");
    assert!(matches!(error, StoreError::LaterVersion { version: 2, newest: 1, .. }));
}

/// If this fails, the layout has changed: then raise the version of the format, and read the old one too.
#[test]
fn the_bytes_of_version_1_are_unchanged() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let bytes = write(&dir.path().join("journal.bin"));
    expect!["817 bytes, BLAKE3 343ed1640b27ebc0c9d1401e166f7e6e97bde925c6ebe8b0b935c8f6962045ab"]
        .assert_eq(&format!("{} bytes, BLAKE3 {}", bytes.len(), blake3::hash(&bytes).to_hex()));
}

/// If this fails, the layout has changed: raise [`JOURNAL_FORMAT_VERSION`], keep the old version readable, and write the new bytes with `UPDATE_EXPECT=1`.
/// The files of earlier versions stay.
#[test]
fn the_bytes_of_records_are_unchanged_and_every_version_is_read() {
    let decision = LoopDecision {
        task: LoopTask {
            session: SessionId(Uuid::from_u128(1)),
            from: KeyframeId(0),
            to: KeyframeId(1),
            source: LoopSource::Appearance(0.25),
            guess: pose(0.5),
        },
        from_from_to: pose(0.75),
        evidence: LoopEvidence::default(),
        verdict: LoopVerdict::Accepted,
        by_hand: true,
        reason: "alike".to_owned(),
    };
    let extends = Some(MapId(Uuid::from_u128(2)));
    let more = [SessionRecord::LoopDecided(decision), SessionRecord::State { extends, distance_m: 2.5 }];
    let records: Vec<_> = records().into_iter().chain(more).collect();
    let contents: Vec<_> =
        records.iter().map(|record| postcard::to_stdvec(record).expect("encoded")).collect();
    let kinds: std::collections::BTreeSet<u8> = contents.iter().map(|content| content[0]).collect();
    let is_unknown = |kind: u8| {
        matches!(postcard::from_bytes::<SessionRecord>(&[kind]), Err(postcard::Error::SerdeDeCustom))
    };
    assert_eq!(kinds, (0..=u8::MAX).take_while(|kind| !is_unknown(*kind)).collect(), "a kind has no sample");
    let journal = journal_of(&contents.iter().map(Vec::as_slice).collect::<Vec<_>>()).expect("short");
    let text: String = journal.iter().map(|byte| format!("{byte:02x}")).collect();
    let golden = format!("../layouts/session_journal_v{JOURNAL_FORMAT_VERSION}.txt");
    expect_file![golden].assert_eq(&format!("{text}\n"));

    let folder = tempfile::tempdir().expect("a folder");
    let read = |bytes: &[u8]| {
        let path = folder.path().join("journal.bin");
        fs::write(&path, bytes).expect("written");
        RecoveredJournal::read(&path, ScanPoses::Wanted).expect("read")
    };
    let expected = read(&journal);
    assert_eq!((expected.damaged_at, expected.decisions.len(), expected.extends), (None, 1, extends));
    for version in 1..=JOURNAL_FORMAT_VERSION {
        let path =
            Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("layouts/session_journal_v{version}.txt"));
        let text = fs::read_to_string(path).expect("the bytes of every version are kept");
        let digits = text.trim();
        let byte = |at: usize| u8::from_str_radix(&digits[at..at + 2], 16).expect("hexadecimal");
        let bytes: Vec<u8> = (0..digits.len()).step_by(2).map(byte).collect();
        assert_eq!(read(&bytes), expected, "version {version}");
    }
}

fn decision(from: u32, to: u32, verdict: LoopVerdict) -> LoopDecision {
    let task = LoopTask {
        session: SessionId(Uuid::from_u128(1)),
        from: KeyframeId(from),
        to: KeyframeId(to),
        source: LoopSource::Appearance(0.5),
        guess: Pose::IDENTITY,
    };
    let evidence = LoopEvidence::default();
    LoopDecision {
        task,
        from_from_to: Pose::IDENTITY,
        verdict,
        evidence,
        by_hand: false,
        reason: String::new(),
    }
}

#[test]
fn replaced_decisions_go_and_all_other_records_stay() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let path = dir.path().join("journal.bin");
    let limits = SessionJournalLimits { max_decisions: 8 };
    let mut journal = SessionJournal::open_with(path.clone(), limits).expect("opens");
    let mut longest = 0;
    for round in 0..20_u32 {
        for record in records() {
            journal.append(&record).expect("written");
        }
        // Two pairs are decided on again and again, and one anew in each round.
        for (from, to) in [(1, 9), (2, 9), (100 + round, 9)] {
            journal
                .append(&SessionRecord::LoopDecided(decision(from, to, LoopVerdict::Held)))
                .expect("written");
        }
        longest = longest.max(count_decisions(&path).expect("read"));
    }
    journal.sync().expect("synced");
    assert!((4..=8).contains(&longest), "{longest} decisions in the file");
    let read = read(&path);
    assert_eq!((read.damaged_at, read.graph.revision, read.trajectory().len()), (None, 3, 40));
    let pairs: Vec<u32> = read.decisions.iter().map(|decision| decision.task.from.0).collect();
    assert!(pairs.ends_with(&[1, 2, 119]), "{pairs:?}");
    // A journal that is opened again knows how many it holds.
    let again = SessionJournal::open_with(path.clone(), limits).expect("opens");
    assert_eq!(again.decisions, read.decisions.len());
    assert!(!files::temporary_path(&path).exists());
}
