//! A topological map as the route graph of Nav2: points and lines of GeoJSON in the map frame, metres. It has two dimensions, so that height and floor
//! are metadata.

use super::{edge_length_m, ends, heading_rad};
use crate::failure::Failure;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use topomap::GeneratedMap;

/// The document.
pub fn geojson(made: &GeneratedMap) -> Result<String, Failure> {
    let numbers: BTreeMap<_, _> =
        made.nodes.iter().enumerate().map(|(number, node)| (node.id, number)).collect();
    let mut features: Vec<Value> = Vec::new();
    for (number, node) in made.nodes.iter().enumerate() {
        let at = node.map_from_node.position;
        features.push(json!({
            "type": "Feature",
            "properties": {
                "id": number,
                "frame": "map",
                "metadata": {
                    "uuid": node.id,
                    "name": node.name,
                    "kind": node.kind,
                    "z_m": at.z,
                    "heading_rad": heading_rad(&node.map_from_node.orientation),
                    "floor": node.floor,
                },
            },
            "geometry": {"type": "Point", "coordinates": [at.x, at.y]},
        }));
    }
    for (number, edge) in made.edges.iter().enumerate() {
        let Some([from, to]) = ends(made, edge) else { continue };
        features.push(json!({
            "type": "Feature",
            "properties": {
                "id": made.nodes.len() + number,
                "startid": numbers.get(&edge.from),
                "endid": numbers.get(&edge.to),
                "cost": edge_length_m(made, edge),
                "overridable": false,
                "metadata": {"uuid": edge.id, "traversal": edge.traversal, "corridor": edge.corridor},
            },
            "geometry": {"type": "MultiLineString", "coordinates": [[[from.x, from.y], [to.x, to.y]]]},
        }));
    }
    let document = json!({"type": "FeatureCollection", "name": "topological map", "features": features});
    Ok(serde_json::to_string_pretty(&document).map_err(Failure::failed)? + "\n")
}
