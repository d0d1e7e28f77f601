//! Seeds of the program's own files.

use crate::clouds::Seed;
use crate::messages::bytes_of_hex;
use fuzzing::STORED_FILES;
use geometry::Isometry;
use messages::{EdgeKind, GraphDelta, GraphEdge, GraphNode, PoseGraph};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use store::{CloudViewpoint, MapPoints, SessionRecord, write_viewpoint_clouds};
use uuid::Uuid;
use vocab::{KeyframeId, Pose, SessionId, Stamp};

pub fn seeds() -> Vec<Seed> {
    [place_seeds(), viewpoint_seeds(), session_seeds(), document_seeds()].concat()
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn place_seeds() -> Vec<Seed> {
    let layouts = root().join("server/store/layouts");
    let mut seeds: Vec<Seed> = vec![("places", "empty", b"AIPLACES\x01\0\0\0\0\0\0\0".to_vec())];
    for entry in fs::read_dir(layouts).unwrap() {
        let path = entry.unwrap().path();
        if path.file_stem().is_some_and(|stem| stem.to_string_lossy().starts_with("places_")) {
            seeds.push(("places", "layout", bytes_of_hex(fs::read_to_string(path).unwrap().trim())));
        }
    }
    seeds
}

fn viewpoint_seeds() -> Vec<Seed> {
    let folder = tempfile::tempdir().unwrap();
    let cloud =
        MapPoints { xyz: (0..20_u8).map(|i| [f32::from(i), 1.0, 2.0]).collect(), intensity: vec![0.5; 20] };
    let visible = [vec![0, 2, 19], Vec::new(), (0..20).collect()];
    let viewpoint =
        |visible| CloudViewpoint { cloud_from_base: Isometry::identity(), lidar: [0.0; 3], visible };
    write_viewpoint_clouds(folder.path(), KeyframeId(0), &cloud, visible.into_iter().map(viewpoint)).unwrap();
    let file = fs::read_dir(folder.path()).unwrap().next().unwrap().unwrap().path();
    vec![("viewpoints", "three", fs::read(file).unwrap())]
}

fn session_seeds() -> Vec<Seed> {
    let node =
        |id| GraphNode { id: KeyframeId(id), stamp: Stamp::from_nanos(7), map_from_keyframe: Pose::IDENTITY };
    let edge = GraphEdge {
        from: KeyframeId(0),
        to: KeyframeId(1),
        kind: EdgeKind::Odometry,
        from_from_to: Pose::IDENTITY,
        information: [[1.0; 6]; 6],
    };
    let delta = GraphDelta {
        session: SessionId(Uuid::nil()),
        base_revision: 1,
        revision: 2,
        nodes: vec![node(1)],
        removed_loops: vec![(KeyframeId(0), KeyframeId(1))],
        edges: vec![edge],
    };
    let graph = PoseGraph { revision: 1, nodes: vec![node(0)], edges: Vec::new() };
    let records = [
        SessionRecord::State { extends: None, distance_m: 1.5 },
        SessionRecord::Graph(Arc::new(graph)),
        SessionRecord::ScanPose { stamp: Stamp::from_nanos(8), map_from_base: Pose::IDENTITY },
        SessionRecord::GraphDelta(Arc::new(delta)),
    ];
    let contents: Vec<Vec<u8>> = records.iter().map(|record| postcard::to_stdvec(record).unwrap()).collect();
    let framed = |content: &Vec<u8>| [&(content.len() as u16).to_le_bytes(), content.as_slice()].concat();
    let input = std::iter::once(vec![0]).chain(contents.iter().map(framed)).collect::<Vec<_>>().concat();
    let slices: Vec<&[u8]> = contents.iter().map(Vec::as_slice).collect();
    let whole = [vec![1], store::fuzzing::session_journal_of(&slices).unwrap()].concat();
    vec![("session_journal", "records", input), ("session_journal", "whole", whole)]
}

fn document_seeds() -> Vec<Seed> {
    let fixture = root().join("tests/fixtures/data-2026-11");
    let map = "a0a00000-0000-4000-8000-000000000001";
    let seed = |(choice, name): (u8, &&str)| {
        let stored = fs::read(fixture.join(name.replace("MAP", map).replace("bin/", "maps/"))).ok();
        // Long files would only slow the fuzzer down.
        let content = stored.filter(|bytes| bytes.len() < 8192).unwrap_or_else(|| match *name {
            "bin/MAP/deleted.json" => {
                b"{\"format_version\":1,\"deleted_at\":1700000000000000000,\"last_pose\":null}".to_vec()
            }
            "uploads/MAP.json" => {
                b"{\"format_version\":1,\"name\":\"Hall\",\"frame\":null,\"problem\":null}".to_vec()
            }
            _ => b"{\"format_version\":1,\"latch\":null,\"checksum\":\"\"}".to_vec(),
        });
        let name = &*format!("{choice:02}").leak();
        ("stored_files", name, [vec![choice], content].concat())
    };
    (0..).zip(&STORED_FILES).map(seed).collect()
}
