//! Seeds of buildings, of changes at a site, and of gauges.

use crate::clouds::Seed;
use sim::{BuildingModel, BuildingModelConfig, Material, Mobility, ModelPart, ModelTriangle, SimulatedSite};
use std::fs;

/// A hall with a box, as the program itself writes it.
fn hall() -> SimulatedSite {
    let part = |name: &str, mobility, [side, height]: [f64; 2], material| {
        let [a, b, c, d] =
            [[-side, -side, height], [side, -side, height], [side, side, height], [-side, side, height]];
        let triangles = vec![
            ModelTriangle { corners: [a, b, c], material },
            ModelTriangle { corners: [a, c, d], material },
        ];
        ModelPart { name: name.to_owned(), mobility, triangles }
    };
    let model = BuildingModel {
        name: "hall".to_owned(),
        parts: vec![
            part("floor", Mobility::Fixed, [5.0, 0.0], Material::Concrete),
            part("box", Mobility::Furniture, [0.5, 0.4], Material::Cardboard),
        ],
        ..BuildingModel::default()
    };
    SimulatedSite::from_model(model, &BuildingModelConfig::default()).unwrap()
}

fn input(sidecar: &[u8], model: &[u8]) -> Vec<u8> {
    [&(sidecar.len() as u16).to_le_bytes(), sidecar, model].concat()
}

pub fn seeds() -> Vec<Seed> {
    let folder = tempfile::tempdir().unwrap();
    let file = site_files::write_site(folder.path(), &hall()).unwrap();
    let model = fs::read(&file).unwrap();
    let sidecar = fs::read(file.with_extension("site.json")).unwrap();
    let all = br#"{"version": 1, "up": "z", "metres_per_unit": 0.5, "docks": [{"position": [1, 2, 0], "heading_deg": 90}],
        "start": {"position": [0, 0, 0]}, "outline": [[0, 0], [1, 0], [1, 1]], "people": [[[0, 0, 0], [1, 0, 0]]],
        "routes": {"round": {"waypoints": [[0, 0]], "speed_m_s": 0.9}}, "furniture": ["bo*"],
        "doors": [{"object": "floor", "hinge": [0, 0, 0]}], "materials": {"concrete": "glass"}, "default_material": "steel"}"#;
    let changes = br#"{"version": 1, "changes": [{"kind": "door", "hinge_m": [50.1, 6.7, 0], "turn_deg": 60},
        {"kind": "leak", "at_m": [1, 2, 0], "radius_m": 0.4, "liquid": "water", "warmer_k": 12},
        {"kind": "gauge-drift", "tag": "PI-101", "per_day": 0.05, "begun_days_ago": 30},
        {"kind": "gauge-stuck", "tag": "TI-104", "value": 61}, {"kind": "lamp-out", "at_m": [1, 2, 3]}]}"#;
    let puts = br#"{"version": 1, "changes": [{"kind": "leak", "at_m": [1, 2, 0], "radius_m": 0.4},
        {"kind": "object-put", "foot_m": [1, -2, 0], "size_m": [0.6, 0.4, 1], "heading_deg": 30, "material": "wood"}]}"#;
    let gauge = br#"{"dials": {"boiler": {"centre": [24, 24], "zero_tick": [9, 39], "mid_tick": [24, 3], "end_tick": [39, 39],
        "range": [0, 6], "direction": "clockwise", "unit": "bar", "image_size": [48, 48], "needle_axis": [24, 24]}}}"#;
    let angles = br#"{"dials": {"boiler": {"centre": [24, 24], "range": [0, 6], "radius_px": 20, "zero_angle_deg": 225,
        "end_angle_deg": 135, "direction": "clockwise", "full_turn": false}}}"#;
    vec![
        ("site_changes", "conditions", changes.to_vec()),
        ("site_changes", "puts", puts.to_vec()),
        ("gauge", "ticks", gauge.to_vec()),
        ("gauge", "angles", angles.to_vec()),
        ("site", "written", input(&sidecar, &model)),
        ("site", "alone", input(b"{}", &model)),
        ("site", "all_fields", input(all, &model)),
    ]
}
