//! Every mistake in a file gives one sentence that names it.

use crate::{glb, read_site, write_site};
use sim::{
    BuildingModel, BuildingModelConfig, Material, Mobility, ModelPart, ModelTriangle, SimulatedSite, Start,
};
use std::fs;
use std::path::Path;
use vocab::Vec3;

fn triangle(corners: [[f64; 3]; 3]) -> ModelTriangle {
    ModelTriangle { corners, material: Material::Floor }
}

fn part(name: &str, triangles: Vec<ModelTriangle>) -> ModelPart {
    ModelPart { name: name.to_owned(), mobility: Mobility::Fixed, triangles }
}

/// A floor of 10 m x 10 m at height 0.
fn floor() -> ModelPart {
    let [a, b, c, d] = [[-5.0, -5.0, 0.0], [5.0, -5.0, 0.0], [5.0, 5.0, 0.0], [-5.0, 5.0, 0.0]];
    part("floor", vec![triangle([a, b, c]), triangle([a, c, d])])
}

fn hall() -> SimulatedSite {
    let model = BuildingModel { name: "hall".to_owned(), parts: vec![floor()], ..BuildingModel::default() };
    SimulatedSite::from_model(model, &BuildingModelConfig::default()).unwrap()
}

/// Writes the hall with that sidecar and reads it; returns the sentence.
fn sentence(sidecar: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let file = write_site(folder.path(), &hall()).unwrap();
    fs::write(file.with_extension("site.json"), sidecar).unwrap();
    let text = read_site(&file).unwrap_err().to_string();
    text.replace(&folder.path().display().to_string(), "")
}

#[test]
fn a_building_needs_no_sidecar() {
    let folder = tempfile::tempdir().unwrap();
    let file = write_site(folder.path(), &hall()).unwrap();
    fs::remove_file(file.with_extension("site.json")).unwrap();
    let site = read_site(&file).unwrap();
    // The robot starts where there is room, near the middle.
    let Start { position, .. } = site.start();
    assert!(position.x.abs() < 1.0 && position.y.abs() < 1.0 && position.z.abs() < 1e-6, "{position:?}");
    // The axis that points up in the file is y.
    assert!(site.solids().iter().all(|solid| solid.shape.bounds().1.z.abs() < 1e-6));
}

#[test]
fn mistakes_in_a_sidecar_are_named() {
    for (sidecar, expected) in [
        ("{", "it cannot be understood: EOF"),
        (r#"{"dock": []}"#, "unknown field `dock`"),
        (r#"{"version": 9, "rooms": 3}"#, "it has version 9, and this program reads versions up to 1"),
        (r#"{"docks": [{"position": [0, 0, 2]}]}"#, "dock 1 at [0, 0, 2] has no floor within 0.3 m"),
        (r#"{"start": {"position": [40, 0, 0]}}"#, "the start at [40, 0, 0] has no floor within 0.3 m"),
        (r#"{"routes": {"round": {"waypoints": []}}}"#, "route \"round\" has too few corners: at least 1"),
        (r#"{"people": [[[0, 0, 0]]]}"#, "path 1 of people has too few corners: at least 2"),
        (r#"{"outline": [[0, 0], [1, 1]]}"#, "the outline has too few corners: at least 3"),
        (r#"{"furniture": ["chair*"]}"#, "furniture names \"chair*\", and the model has no such object"),
        (
            r#"{"doors": [{"object": "door", "hinge": [0, 0, 0]}]}"#,
            "doors names \"door\", and the model has no",
        ),
        (
            r#"{"materials": {"Wall": "glass"}}"#,
            "materials names \"Wall\", and the model has no such material",
        ),
        (r#"{"materials": {"floor": "gold"}}"#, "there is no material \"gold\"; the materials are concrete,"),
        (r#"{"metres_per_unit": 0}"#, "metres_per_unit must be a positive number"),
        (r#"{"up": "z"}"#, "the robot has room on none of its floors"),
    ] {
        let text = sentence(sidecar);
        assert!(text.contains(expected), "{sidecar}: {text}");
        assert!(text.starts_with("/hall."), "{sidecar}: {text} does not begin with its file");
        assert!(!text.contains('\n'), "{sidecar}: {text}");
    }
}

fn read_bytes(bytes: &[u8]) -> Result<SimulatedSite, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("b.glb");
    fs::write(&file, bytes).unwrap();
    read_site(&file).map_err(|error| error.to_string())
}

/// A GLB file of that JSON and no points.
fn glb(json: &str) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF".to_vec();
    bytes.extend(2_u32.to_le_bytes());
    bytes.extend((20 + json.len() as u32).to_le_bytes());
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(json);
    bytes
}

/// Nodes that each contain the next one twice: 2 to the power of their number, if each were read wherever it is named.
fn twofold(nodes: usize) -> String {
    let all: Vec<String> =
        (0..nodes).map(|node| format!(r#"{{"children": [{0}, {0}]}}"#, (node + 1).min(nodes - 1))).collect();
    all.join(", ")
}

/// Nodes that each contain the next one.
fn nested(nodes: usize) -> String {
    let parents: Vec<String> = (1..nodes).map(|node| format!(r#"{{"children": [{node}]}}"#)).collect();
    format!("{}, {{}}", parents.join(", "))
}

#[test]
fn mistakes_in_a_model_are_named() {
    let asset = r#""asset": {"version": "2.0"}"#;
    let mesh = r#""scenes": [{"nodes": [0]}], "nodes": [{"name": "wall", "mesh": 0}]"#;
    for (bytes, expected) in [
        (b"solid stl".to_vec(), "it is no binary glTF file"),
        (b"glTF\x02\0\0\0\x03\0\0\0".to_vec(), "it is no binary glTF file"),
        (b"glTF\x02\0\0\0\xff\0\0\0abc".to_vec(), "it is incomplete"),
        (glb("{"), "it cannot be understood"),
        (glb(&format!("{{{asset}}}")), "it has no triangles"),
        (
            glb(&format!(r#"{{{asset}, "extensionsRequired": ["KHR_draco_mesh_compression"]}}"#)),
            "it needs the extension KHR_draco_mesh_compression",
        ),
        (glb(&format!("{{{asset}, {mesh}}}")), "the mesh of \"wall\" is damaged"),
        (
            glb(&format!(
                r#"{{{asset}, {mesh}, "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 7}}}}]}}]}}"#
            )),
            "the mesh of \"wall\" is damaged",
        ),
        (
            glb(&format!(r#"{{{asset}, "scenes": [{{"nodes": [0]}}], "nodes": [{{"children": [0]}}]}}"#)),
            "lies in itself or in two others",
        ),
        (
            glb(&format!(r#"{{{asset}, "scenes": [{{"nodes": [0]}}], "nodes": [{}]}}"#, twofold(60))),
            "in two others",
        ),
        (
            glb(&format!(r#"{{{asset}, "scenes": [{{"nodes": [0]}}], "nodes": [{}]}}"#, nested(300))),
            "nested too deeply",
        ),
    ] {
        let text = read_bytes(&bytes).unwrap_err();
        assert!(text.contains(expected), "{expected}: {text}");
    }
    assert!(read_site(Path::new("/nowhere/b.glb")).unwrap_err().to_string().contains("it cannot be read"));
}

#[test]
fn mistakes_in_triangles_are_named() {
    let config = BuildingModelConfig { max_triangles: 3, ..BuildingModelConfig::default() };
    let with = |parts: Vec<ModelPart>| {
        let model = BuildingModel { parts, ..BuildingModel::default() };
        SimulatedSite::from_model(model, &config).map(|_| ()).unwrap_err().to_string()
    };
    let far = triangle([[0.0, 0.0, 0.0], [1e6, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let nan = triangle([[0.0, 0.0, 0.0], [f64::NAN, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let flat = triangle([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    assert!(with(vec![floor(), floor()]).contains("it has 4 triangles, and at most 3 are read"));
    assert!(with(vec![floor(), part("roof", vec![nan])]).contains("a corner of \"roof\" is not a finite"));
    assert!(with(vec![floor(), part("roof", vec![far])]).contains("farther than 1000 m from the origin"));
    assert!(with(vec![part("line", vec![flat])]).contains("it has no triangles"));
    let start = Some(Start { position: Vec3::new(0.0, 0.0, 1.0), yaw: 0.0 });
    let model = BuildingModel { parts: vec![floor()], start, ..BuildingModel::default() };
    let text = SimulatedSite::from_model(model, &config).map(|_| ()).unwrap_err().to_string();
    assert!(text.contains("the start at [0, 0, 1] has no floor"), "{text}");
}

#[test]
fn a_cut_or_changed_file_never_panics() {
    let folder = tempfile::tempdir().unwrap();
    let file = write_site(folder.path(), &hall()).unwrap();
    let bytes = fs::read(&file).unwrap();
    for length in 0..bytes.len() {
        let _ = glb::read(&bytes[..length], 1000);
    }
    for at in 0..bytes.len() {
        for value in [0, 0x39, 0xff] {
            let mut changed = bytes.clone();
            changed[at] = value;
            let _ = glb::read(&changed, 1000);
        }
    }
}
