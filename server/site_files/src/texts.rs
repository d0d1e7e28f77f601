//! Sentences for people, by key. English. The name of the file precedes them.

use vocab::{MAX_SHOWN_NAME_CHARS, legible};

/// Characters of a list of names, or of a library's error, that a sentence shows, at most.
const MAX_SHOWN_CHARS: usize = 200;

fn shown(name: &str) -> String {
    legible(name, MAX_SHOWN_NAME_CHARS)
}

/// Whatever is no GLB file.
pub(crate) const NOT_GLB: &str =
    "it is no binary glTF file: export the building as glTF 2.0 with the format glTF Binary (.glb)";
/// A file that ends early.
pub(crate) const CUT: &str = "it is incomplete: export or copy it again";
/// Nodes that are nested very deeply.
pub(crate) const DEEP: &str =
    "its objects are nested too deeply: apply their parents' transformations and clear the parents";
/// Nodes that two nodes contain, or that contain themselves.
pub(crate) const CONTAINED_TWICE: &str =
    "one of its objects lies in itself or in two others: export the building again";
/// Points in another file.
pub(crate) const EXTERNAL: &str =
    "its points lie in another file: export it with the format glTF Binary (.glb), which holds everything";
/// A sidecar of a newer program.
pub(crate) fn newer_version(version: u32, known: u32) -> String {
    format!("it has version {version}, and this program reads versions up to {known}: update the program")
}
/// A file of changes of another version.
pub(crate) fn other_version(version: u32, known: u32) -> String {
    format!(
        "it has version {version}, and this program reads version {known}: write the file for that version"
    )
}
/// More changes than are read.
pub(crate) fn too_many_changes(limit: usize) -> String {
    format!("it has more than {limit} changes or more than 1 MB: leave some out")
}
/// Where in the file a mistake is, by the number of the change from 1.
pub(crate) fn in_change(number: usize, reason: &str) -> String {
    format!("change {number}: {reason}")
}
/// A side of an object that is too short or too long.
pub(crate) fn bad_side([least, most]: [f64; 2]) -> String {
    format!(
        "a side of an object is not from {least} to {most} m: write size_m as length, width and height in metres"
    )
}
/// A point that is on no site.
pub(crate) fn far_point(limit_m: f64) -> String {
    format!(
        "a point is farther than {limit_m} m from the origin: write it in metres in the frame of the site"
    )
}
/// JSON that is not a glTF document or not a sidecar.
pub(crate) fn bad_json(cause: &dyn std::fmt::Display) -> String {
    format!("it cannot be understood: {}", legible(&cause.to_string(), MAX_SHOWN_CHARS))
}
/// The file is missing or cannot be read.
pub(crate) fn not_read(cause: &dyn std::fmt::Display) -> String {
    format!("it cannot be read: {cause}")
}
/// The file cannot be written.
pub(crate) fn not_written(cause: &dyn std::fmt::Display) -> String {
    format!("it cannot be written: {cause}")
}
/// An extension without which the points are not known.
pub(crate) fn extension(name: &str) -> String {
    let name = shown(name);
    format!("it needs the extension {name}, which is not supported: export it without compression")
}
/// Points or corners of triangles that do not fit their buffer or their type.
pub(crate) fn bad_mesh(node: &str) -> String {
    let node = shown(node);
    format!(
        "the mesh of \"{node}\" is damaged or has points of an unsupported type: export it again without compression"
    )
}
/// More triangles than are read.
pub(crate) fn too_many_triangles(limit: usize) -> String {
    format!("it has more than {limit} triangles: simplify its meshes")
}
/// A name of the sidecar that the model lacks.
pub(crate) fn no_such_object(field: &str, name: &str) -> String {
    format!("{field} names \"{}\", and the model has no such object", shown(name))
}
/// A material of the sidecar that the model lacks.
pub(crate) fn no_such_material(name: &str, known: &[&str]) -> String {
    let (name, known) = (shown(name), legible(&known.join(", "), MAX_SHOWN_CHARS));
    format!("materials names \"{name}\", and the model has no such material; it has: {known}")
}
/// A number that must be positive.
pub(crate) const BAD_SCALE: &str = "metres_per_unit must be a positive number";
/// A number that is none.
pub(crate) fn not_finite(what: &str) -> String {
    format!("{what} is not a finite number")
}
