//! `FILE.site.json`: what a model of a building does not hold. Positions are in the site frame: z up, metres, as Blender shows them.

use crate::glb::{GltfDocument, IndexedTriangle, PlacedMesh};
use crate::texts;
use serde::{Deserialize, Serialize};
use sim::{BuildingModel, Material, Mobility, ModelPart, ModelTriangle, SimulatedDock, SiteRoute, Start};
use std::collections::BTreeMap;
use vocab::Vec3;

/// The newest version of the file that is read and written.
const VERSION: u32 = 1;
/// Material of surfaces that neither name says anything about.
const DEFAULT_MATERIAL: &str = "plaster";

/// The file. Every field has a default.
#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Sidecar {
    /// Version of the file.
    version: u32,
    /// The axis of the file that points up: `y` as glTF demands, or `z` if it was exported otherwise.
    up: Up,
    /// Length of a unit of the file, metres.
    metres_per_unit: f64,
    /// Charging docks.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    docks: Vec<Place>,
    /// Start of the robot where there is no dock.
    #[serde(skip_serializing_if = "Option::is_none")]
    start: Option<Place>,
    /// Corners of the ground plan.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    outline: Vec<[f64; 2]>,
    /// Walks for recordings and benchmarks.
    routes: Routes,
    /// Closed paths of people, at their feet.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    people: Vec<Vec<[f64; 3]>>,
    /// Objects that may stand elsewhere on another day. A `*` at the end stands for any text.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    furniture: Vec<String>,
    /// Door leaves that may stand at another angle on another day.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    doors: Vec<Door>,
    /// Materials of the simulator by names of the model's materials.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    materials: BTreeMap<String, String>,
    /// Material of all other surfaces whose own material has no name of the simulator's materials.
    default_material: String,
}

impl Default for Sidecar {
    fn default() -> Self {
        Self {
            version: VERSION,
            up: Up::Y,
            metres_per_unit: 1.0,
            docks: Vec::new(),
            start: None,
            outline: Vec::new(),
            routes: Routes::default(),
            people: Vec::new(),
            furniture: Vec::new(),
            doors: Vec::new(),
            materials: BTreeMap::new(),
            default_material: DEFAULT_MATERIAL.to_owned(),
        }
    }
}

#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq)]
#[serde(rename_all = "lowercase")]
enum Up {
    Y,
    Z,
}

/// A position on the ground with a heading.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
struct Place {
    position: [f64; 3],
    /// Counter-clockwise from the x axis, degrees.
    #[serde(default)]
    heading_deg: f64,
}

#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
struct Routes {
    #[serde(skip_serializing_if = "Option::is_none")]
    round: Option<Walk>,
    #[serde(skip_serializing_if = "Option::is_none")]
    short: Option<Walk>,
}

#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
struct Walk {
    /// Where it begins; by default at the first dock, or at the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    start: Option<Place>,
    waypoints: Vec<[f64; 2]>,
    #[serde(default = "Walk::usual_speed")]
    speed_m_s: f64,
}

impl Walk {
    fn usual_speed() -> f64 {
        1.0
    }
}

#[derive(Clone, Debug, Deserialize, Serialize, PartialEq)]
#[serde(deny_unknown_fields)]
struct Door {
    object: String,
    /// A point on the axis of the hinge.
    hinge: [f64; 3],
}

/// The version alone, so that a newer file is recognised before its unknown fields are.
#[derive(Deserialize)]
struct Version {
    #[serde(default = "Version::first")]
    version: u32,
}

impl Version {
    fn first() -> u32 {
        1
    }
}

impl Place {
    fn start(&self) -> Start {
        Start { position: vec3(self.position), yaw: self.heading_deg.to_radians() }
    }

    fn new(position: Vec3, yaw: f64) -> Self {
        Self { position: [position.x, position.y, position.z], heading_deg: yaw.to_degrees() }
    }
}

fn vec3([x, y, z]: [f64; 3]) -> Vec3 {
    Vec3::new(x, y, z)
}

/// Reads the text of a sidecar.
///
/// # Errors
/// A sentence that says what is wrong.
pub(crate) fn parse(text: &str) -> Result<Sidecar, String> {
    let version: Version = serde_json::from_str(text).map_err(|error| texts::bad_json(&error))?;
    if version.version > VERSION {
        return Err(texts::newer_version(version.version, VERSION));
    }
    let sidecar: Sidecar = serde_json::from_str(text).map_err(|error| texts::bad_json(&error))?;
    if !(sidecar.metres_per_unit.is_finite() && sidecar.metres_per_unit > 0.0) {
        return Err(texts::BAD_SCALE.to_owned());
    }
    Ok(sidecar)
}

/// The text of the sidecar of a model.
///
/// # Errors
/// When a number of the model is not finite.
pub(crate) fn to_text(model: &BuildingModel) -> Result<String, String> {
    let walk = |name: &str| {
        let route = model.routes.iter().find(|route| route.name == name)?;
        Some(Walk {
            start: Some(Place::new(route.start.position, route.start.yaw)),
            waypoints: route.waypoints.clone(),
            speed_m_s: route.speed,
        })
    };
    let path = |corners: &Vec<Vec3>| corners.iter().map(|at| [at.x, at.y, at.z]).collect();
    let of = |wanted: fn(&ModelPart) -> bool| {
        model.parts.iter().filter(move |part| wanted(part)).map(|part| part.name.clone())
    };
    let doors = model.parts.iter().filter_map(|part| match part.mobility {
        Mobility::Door { hinge } => {
            Some(Door { object: part.name.clone(), hinge: [hinge.x, hinge.y, hinge.z] })
        }
        _ => None,
    });
    let sidecar = Sidecar {
        docks: model.docks.iter().map(|dock| Place::new(dock.position, dock.yaw)).collect(),
        start: model.start.map(|start| Place::new(start.position, start.yaw)),
        outline: model.outline.clone(),
        routes: Routes { round: walk("round"), short: walk("short") },
        people: model.pedestrian_paths.iter().map(path).collect(),
        furniture: of(|part| part.mobility == Mobility::Furniture).collect(),
        doors: doors.collect(),
        ..Sidecar::default()
    };
    serde_json::to_string_pretty(&sidecar).map_err(|error| texts::not_written(&error))
}

/// Joins a document and its sidecar.
///
/// # Errors
/// A sentence about the sidecar.
pub(crate) fn model(
    name: String,
    document: &GltfDocument,
    sidecar: &Sidecar,
) -> Result<BuildingModel, String> {
    sidecar.check_numbers()?;
    let materials = sidecar.materials(&document.materials)?;
    let default = material(&sidecar.default_material)?;
    for pattern in &sidecar.furniture {
        if !document.meshes.iter().any(|mesh| mesh.is_named(pattern)) {
            return Err(texts::no_such_object("furniture", pattern));
        }
    }
    for door in &sidecar.doors {
        if !document.meshes.iter().any(|mesh| mesh.is_named(&door.object)) {
            return Err(texts::no_such_object("doors", &door.object));
        }
    }
    let mut parts: Vec<ModelPart> = Vec::new();
    for mesh in &document.meshes {
        let (name, mobility) = sidecar.mobility(mesh);
        let triangle = |(corners, index): &IndexedTriangle| ModelTriangle {
            corners: corners.map(|corner| sidecar.site_from_file(corner)),
            material: index.and_then(|index| materials.get(index).copied().flatten()).unwrap_or(default),
        };
        let triangles = mesh.triangles.iter().map(triangle);
        // Meshes below one object move together.
        match parts.iter_mut().find(|part| part.name == name && part.mobility == mobility) {
            Some(part) => part.triangles.extend(triangles),
            None => parts.push(ModelPart { name, mobility, triangles: triangles.collect() }),
        }
    }
    let first = sidecar.docks.first().or(sidecar.start.as_ref());
    let routes = [("round", &sidecar.routes.round), ("short", &sidecar.routes.short)];
    let routes = routes.into_iter().filter_map(|(name, walk)| {
        let walk = walk.as_ref()?;
        // Without any place, the first waypoint on the ground is taken.
        let [x, y] = walk.waypoints.first().copied().unwrap_or_default();
        let start = walk
            .start
            .as_ref()
            .or(first)
            .map_or_else(|| Start { position: Vec3::new(x, y, 0.0), yaw: 0.0 }, Place::start);
        Some(SiteRoute { name, start, waypoints: walk.waypoints.clone(), speed: walk.speed_m_s })
    });
    let dock =
        |place: &Place| SimulatedDock { position: vec3(place.position), yaw: place.heading_deg.to_radians() };
    Ok(BuildingModel {
        name,
        parts,
        docks: sidecar.docks.iter().map(dock).collect(),
        start: sidecar.start.map(|place| place.start()),
        outline: sidecar.outline.clone(),
        routes: routes.collect(),
        pedestrian_paths: sidecar
            .people
            .iter()
            .map(|path| path.iter().copied().map(vec3).collect())
            .collect(),
    })
}

impl Sidecar {
    fn site_from_file(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let turned = match self.up {
            Up::Y => [x, -z, y],
            Up::Z => [x, y, z],
        };
        turned.map(|c| c * self.metres_per_unit)
    }

    /// The part to which a mesh belongs, and whether that moves.
    fn mobility(&self, mesh: &PlacedMesh) -> (String, Mobility) {
        for name in &mesh.names {
            if let Some(door) = self.doors.iter().find(|door| matches(&door.object, name)) {
                return (name.clone(), Mobility::Door { hinge: vec3(door.hinge) });
            }
            if self.furniture.iter().any(|pattern| matches(pattern, name)) {
                return (name.clone(), Mobility::Furniture);
            }
        }
        (mesh.names.last().cloned().unwrap_or_default(), Mobility::Fixed)
    }

    /// For each material of the model, its material in the simulator; `None` for the default.
    fn materials(&self, names: &[String]) -> Result<Vec<Option<Material>>, String> {
        for name in self.materials.keys() {
            if !names.contains(name) {
                let known: Vec<&str> = names.iter().map(String::as_str).collect();
                return Err(texts::no_such_material(name, &known));
            }
        }
        let one = |name: &String| match self.materials.get(name) {
            Some(chosen) => material(chosen).map(Some),
            None => Ok(Material::ALL.into_iter().find(|known| resembles(name, known.name()))),
        };
        names.iter().map(one).collect()
    }

    fn check_numbers(&self) -> Result<(), String> {
        let walks = self.routes.round.iter().chain(&self.routes.short);
        let places =
            self.docks.iter().chain(&self.start).chain(walks.clone().filter_map(|w| w.start.as_ref()));
        let mut numbers: Vec<(&str, f64)> = Vec::new();
        for place in places {
            numbers.extend(place.position.map(|c| ("a position", c)));
            numbers.push(("heading_deg", place.heading_deg));
        }
        numbers.extend(self.outline.iter().flatten().map(|c| ("outline", *c)));
        numbers.extend(self.people.iter().flatten().flatten().map(|c| ("people", *c)));
        for walk in walks {
            numbers.extend(walk.waypoints.iter().flatten().map(|c| ("a waypoint", *c)));
            numbers.push(("speed_m_s", walk.speed_m_s));
        }
        match numbers.into_iter().find(|(_, number)| !number.is_finite()) {
            Some((what, _)) => Err(texts::not_finite(what)),
            None => Ok(()),
        }
    }
}

impl PlacedMesh {
    fn is_named(&self, pattern: &str) -> bool {
        self.names.iter().any(|name| matches(pattern, name))
    }
}

/// Whether a pattern, whose last character may be `*`, stands for a name.
fn matches(pattern: &str, name: &str) -> bool {
    pattern.strip_suffix('*').map_or(pattern == name, |start| name.starts_with(start))
}

/// Whether a material of a model is one of the simulator by its name: "Dark paint.001" is "dark-paint".
fn resembles(name: &str, known: &str) -> bool {
    let letters = |text: &str| -> String {
        text.chars().filter(char::is_ascii_alphabetic).map(|c| c.to_ascii_lowercase()).collect()
    };
    letters(name) == letters(known)
}

fn material(name: &str) -> Result<Material, String> {
    name.parse().map_err(|error| format!("{error}"))
}
