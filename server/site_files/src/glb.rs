//! Binary glTF: bytes to triangles and back. The document's types are those of the crate `gltf`. Its points are read here, because that crate trusts
//! the indices of a document.

use crate::texts;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::mesh::{Mode, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Index, Node, Root};
use nalgebra::{Matrix4, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use serde_json::json;
use sim::{Material, ModelPart};
use std::borrow::Cow;
use std::collections::HashMap;

/// Extensions that change only how a surface looks, or that are read.
const HARMLESS_EXTENSIONS: [&str; 2] = ["KHR_mesh_quantization", "KHR_texture_transform"];
/// Start of the names of extensions of materials.
const MATERIAL_EXTENSIONS: &str = "KHR_materials_";
/// Greatest depth of the tree of nodes.
const MAX_DEPTH: usize = 200;
/// Length of the header of a GLB file, bytes.
const HEADER_BYTES: usize = 12;

/// Corners of a triangle, and the index of its material.
pub(crate) type IndexedTriangle = ([[f64; 3]; 3], Option<usize>);

/// A mesh with its place in the scene.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlacedMesh {
    /// Names of the node and of the nodes that contain it, from the root.
    pub(crate) names: Vec<String>,
    /// Triangles in the frame of the file.
    pub(crate) triangles: Vec<IndexedTriangle>,
}

/// The content of a GLB file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GltfDocument {
    pub(crate) meshes: Vec<PlacedMesh>,
    /// Names of the materials. A material without a name has an empty one.
    pub(crate) materials: Vec<String>,
}

/// Reads a GLB file of at most `max_triangles` triangles.
///
/// # Errors
/// A sentence that says what is wrong.
pub(crate) fn read(bytes: &[u8], max_triangles: usize) -> Result<GltfDocument, String> {
    // The parser subtracts the length of the header from this number.
    let length = bytes.get(8..HEADER_BYTES).and_then(|field| <[u8; 4]>::try_from(field).ok());
    let is_long_enough = length.is_some_and(|field| u32::from_le_bytes(field) as usize >= HEADER_BYTES);
    if !bytes.starts_with(b"glTF") || !is_long_enough {
        return Err(texts::NOT_GLB.to_owned());
    }
    let glb = gltf::binary::Glb::from_slice(bytes).map_err(|_| texts::CUT.to_owned())?;
    let root = Root::from_slice(&glb.json).map_err(|error| texts::bad_json(&error))?;
    let is_harmless =
        |name: &str| HARMLESS_EXTENSIONS.contains(&name) || name.starts_with(MATERIAL_EXTENSIONS);
    if let Some(name) = root.extensions_required.iter().find(|name| !is_harmless(name)) {
        return Err(texts::extension(name));
    }
    let materials = root.materials.iter().map(|one| one.name.clone().unwrap_or_default()).collect();
    let mut reader = Reader {
        root: &root,
        bin: glb.bin.as_deref(),
        max_triangles,
        is_read: vec![false; root.nodes.len()],
        meshes: Vec::new(),
    };
    for node in reader.roots() {
        reader.read_node(node, &Matrix4::identity(), &[])?;
    }
    Ok(GltfDocument { meshes: reader.meshes, materials })
}

struct Reader<'a> {
    root: &'a Root,
    bin: Option<&'a [u8]>,
    /// Number of triangles that may still come.
    max_triangles: usize,
    /// By node: whether it was read. Each is in one place, so that few nodes cannot stand for a great many.
    is_read: Vec<bool>,
    meshes: Vec<PlacedMesh>,
}

impl<'a> Reader<'a> {
    /// The nodes of the scene that is shown first; without scenes, the nodes that no other contains.
    fn roots(&self) -> Vec<Index<Node>> {
        let shown = self.root.scene.map_or(0, |scene| scene.value());
        if let Some(scene) = self.root.scenes.get(shown) {
            return scene.nodes.clone();
        }
        let contained: Vec<usize> =
            self.root.nodes.iter().filter_map(|n| n.children.as_ref()).flatten().map(Index::value).collect();
        let nodes = 0..self.root.nodes.len();
        nodes.filter(|node| !contained.contains(node)).map(|node| Index::new(node as u32)).collect()
    }

    fn read_node(
        &mut self,
        index: Index<Node>,
        parent: &Matrix4<f64>,
        above: &[String],
    ) -> Result<(), String> {
        let Some(node) = self.root.nodes.get(index.value()) else {
            return Err(texts::bad_mesh(above.last().map_or("", String::as_str)));
        };
        if above.len() > MAX_DEPTH {
            return Err(texts::DEEP.to_owned());
        }
        if std::mem::replace(&mut self.is_read[index.value()], true) {
            return Err(texts::CONTAINED_TWICE.to_owned());
        }
        let mut names = above.to_vec();
        names.push(node.name.clone().unwrap_or_else(|| format!("node {}", index.value())));
        let placed = parent * transformation(node);
        if let Some(mesh) = node.mesh {
            let triangles = self
                .triangles(mesh.value(), &placed)
                .ok_or_else(|| texts::bad_mesh(names.last().map_or("", String::as_str)))??;
            self.meshes.push(PlacedMesh { names: names.clone(), triangles });
        }
        for child in node.children.iter().flatten() {
            self.read_node(*child, &placed, &names)?;
        }
        Ok(())
    }

    /// The triangles of a mesh under a transformation. `None`: damaged; the inner error: another mistake.
    fn triangles(
        &mut self,
        mesh: usize,
        placed: &Matrix4<f64>,
    ) -> Option<Result<Vec<IndexedTriangle>, String>> {
        let mut triangles = Vec::new();
        for primitive in &self.root.meshes.get(mesh)?.primitives {
            let Checked::Valid(mode) = primitive.mode else { return None };
            if matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
                continue;
            }
            let positions = primitive.attributes.get(&Checked::Valid(Semantic::Positions))?;
            let positions = self.root.accessors.get(positions.value())?;
            if self.is_external(positions) {
                return Some(Err(texts::EXTERNAL.to_owned()));
            }
            let positions = self.values(positions, Type::Vec3)?;
            let indices = match primitive.indices {
                None => None,
                Some(indices) => {
                    let accessor = self.root.accessors.get(indices.value())?;
                    Some(self.values(accessor, Type::Scalar)?)
                }
            };
            let corners = indices.as_ref().map_or(positions.count, |indices| indices.count);
            let count = match mode {
                Mode::Triangles => corners / 3,
                _ => corners.saturating_sub(2),
            };
            let Some(left) = self.max_triangles.checked_sub(count) else {
                return Some(Err(texts::too_many_triangles(triangles.len() + self.max_triangles)));
            };
            self.max_triangles = left;
            for number in 0..count {
                let at = match mode {
                    Mode::TriangleFan => [0, number + 1, number + 2],
                    Mode::TriangleStrip => [number, number + 1, number + 2],
                    _ => [3 * number, 3 * number + 1, 3 * number + 2],
                };
                let mut corner = [[0.0; 3]; 3];
                for (slot, at) in corner.iter_mut().zip(at) {
                    let point = match &indices {
                        None => at,
                        Some(indices) => indices.at(at, 0)? as usize,
                    };
                    let [x, y, z] = [0, 1, 2].map(|lane| positions.at(point, lane));
                    *slot = placed.transform_point(&Point3::new(x?, y?, z?)).into();
                }
                triangles.push((corner, primitive.material.map(|material| material.value())));
            }
        }
        Some(Ok(triangles))
    }

    /// Whether the values lie outside the file.
    fn is_external(&self, accessor: &Accessor) -> bool {
        let view = accessor.buffer_view.and_then(|view| self.root.buffer_views.get(view.value()));
        let buffer = view.and_then(|view| self.root.buffers.get(view.buffer.value()));
        buffer.is_some_and(|buffer| buffer.uri.is_some())
    }

    /// The values of an accessor of that type.
    fn values(&self, accessor: &Accessor, of: Type) -> Option<Values<'a>> {
        let (Checked::Valid(kind), Checked::Valid(component)) = (accessor.type_, accessor.component_type)
        else {
            return None;
        };
        if kind != of || accessor.sparse.is_some() {
            return None;
        }
        let view = self.root.buffer_views.get(accessor.buffer_view?.value())?;
        if view.buffer.value() != 0 {
            return None;
        }
        let from = usize::try_from(view.byte_offset.unwrap_or_default().0).ok()?;
        let length = usize::try_from(view.byte_length.0).ok()?;
        let bytes = self.bin?.get(from..from.checked_add(length)?)?;
        let bytes = bytes.get(usize::try_from(accessor.byte_offset.unwrap_or_default().0).ok()?..)?;
        let (size, greatest) = match component.0 {
            ComponentType::I8 => (1, f64::from(i8::MAX)),
            ComponentType::U8 => (1, f64::from(u8::MAX)),
            ComponentType::I16 => (2, f64::from(i16::MAX)),
            ComponentType::U16 => (2, f64::from(u16::MAX)),
            ComponentType::U32 => (4, f64::from(u32::MAX)),
            ComponentType::F32 => (4, 1.0),
        };
        let factor = if accessor.normalized { 1.0 / greatest } else { 1.0 };
        let lanes = if of == Type::Vec3 { 3 } else { 1 };
        let count = usize::try_from(accessor.count.0).ok()?;
        let stride = view.byte_stride.map_or(size * lanes, |stride| stride.0);
        let ends_in_file =
            || Some((count - 1).checked_mul(stride)?.checked_add(size * lanes)? <= bytes.len());
        if count > 0 && (stride == 0 || !ends_in_file()?) {
            return None;
        }
        Some(Values { bytes, count, stride, component: component.0, size, factor })
    }
}

/// The values of an accessor, all of which lie in the file.
struct Values<'a> {
    bytes: &'a [u8],
    count: usize,
    /// Bytes from one to the next.
    stride: usize,
    component: ComponentType,
    /// Bytes of a component.
    size: usize,
    factor: f64,
}

impl Values<'_> {
    /// A component of a value. Normalised integers become fractions.
    fn at(&self, item: usize, lane: usize) -> Option<f64> {
        if item >= self.count {
            return None;
        }
        let at = item * self.stride + lane * self.size;
        Some(component_value(self.bytes.get(at..at + self.size)?, self.component)? * self.factor)
    }
}

fn component_value(bytes: &[u8], component: ComponentType) -> Option<f64> {
    Some(match component {
        ComponentType::I8 => f64::from(i8::from_le_bytes(bytes.try_into().ok()?)),
        ComponentType::U8 => f64::from(u8::from_le_bytes(bytes.try_into().ok()?)),
        ComponentType::I16 => f64::from(i16::from_le_bytes(bytes.try_into().ok()?)),
        ComponentType::U16 => f64::from(u16::from_le_bytes(bytes.try_into().ok()?)),
        ComponentType::U32 => f64::from(u32::from_le_bytes(bytes.try_into().ok()?)),
        ComponentType::F32 => f64::from(f32::from_le_bytes(bytes.try_into().ok()?)),
    })
}

/// The transformation of a node in its parent.
fn transformation(node: &Node) -> Matrix4<f64> {
    if let Some(matrix) = node.matrix {
        return Matrix4::from_column_slice(&matrix.map(f64::from));
    }
    let [x, y, z] = node.translation.unwrap_or_default().map(f64::from);
    let [i, j, k, w] = node.rotation.unwrap_or_default().0.map(f64::from);
    let scale = node.scale.unwrap_or([1.0; 3]).map(f64::from);
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
    Translation3::new(x, y, z).to_homogeneous()
        * rotation.to_homogeneous()
        * Matrix4::new_nonuniform_scaling(&Vector3::from(scale))
}

/// Writes parts as a GLB file, one object for each. Site frame in, y up in the file, as glTF demands.
///
/// # Errors
/// When the file would be larger than the format allows, 4 GiB.
pub(crate) fn write(parts: &[ModelPart]) -> Result<Vec<u8>, String> {
    let mut writer = Writer::default();
    for part in parts {
        writer.add(part);
    }
    let nodes: Vec<usize> = (0..writer.nodes.len()).collect();
    let document = json!({
        "asset": { "version": "2.0", "generator": concat!("AutoInspect ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": nodes }],
        "nodes": writer.nodes,
        "meshes": writer.meshes,
        "materials": writer.materials.iter().map(|material| material_json(*material)).collect::<Vec<_>>(),
        "accessors": writer.accessors,
        "bufferViews": writer.views,
        "buffers": [{ "byteLength": writer.bin.len() }],
    });
    let length = HEADER_BYTES + writer.bin.len();
    let header = gltf::binary::Header {
        magic: *b"glTF",
        version: 2,
        length: u32::try_from(length).map_err(|error| texts::not_written(&error))?,
    };
    let glb = gltf::binary::Glb {
        header,
        json: Cow::Owned(document.to_string().into_bytes()),
        bin: Some(Cow::Owned(writer.bin)),
    };
    glb.to_vec().map_err(|error| texts::not_written(&error))
}

/// Points already written, by the bits of their coordinates, with their number.
type PointNumbers = HashMap<[u32; 3], u32>;

#[derive(Default)]
struct Writer {
    nodes: Vec<serde_json::Value>,
    meshes: Vec<serde_json::Value>,
    materials: Vec<Material>,
    accessors: Vec<serde_json::Value>,
    views: Vec<serde_json::Value>,
    bin: Vec<u8>,
}

impl Writer {
    fn add(&mut self, part: &ModelPart) {
        let mut by_material: Vec<(Material, Vec<[[f64; 3]; 3]>)> = Vec::new();
        for triangle in &part.triangles {
            match by_material.iter_mut().find(|(material, _)| *material == triangle.material) {
                Some((_, triangles)) => triangles.push(triangle.corners),
                None => by_material.push((triangle.material, vec![triangle.corners])),
            }
        }
        let primitives: Vec<_> =
            by_material.iter().map(|(material, triangles)| self.primitive(*material, triangles)).collect();
        if primitives.is_empty() {
            return;
        }
        self.nodes.push(json!({ "name": part.name, "mesh": self.meshes.len() }));
        self.meshes.push(json!({ "name": part.name, "primitives": primitives }));
    }

    fn primitive(&mut self, material: Material, triangles: &[[[f64; 3]; 3]]) -> serde_json::Value {
        let mut points: Vec<[f32; 3]> = Vec::new();
        let mut numbers = PointNumbers::new();
        let mut corners: Vec<u32> = Vec::with_capacity(3 * triangles.len());
        for [x, y, z] in triangles.iter().flatten() {
            // z up becomes y up.
            let point = [*x, *z, -*y].map(|c| c as f32);
            let number = *numbers.entry(point.map(f32::to_bits)).or_insert_with(|| {
                points.push(point);
                points.len() as u32 - 1
            });
            corners.push(number);
        }
        let limit = |pick: fn(f32, f32) -> f32| {
            points.iter().copied().reduce(|a, b| [0, 1, 2].map(|axis| pick(a[axis], b[axis])))
        };
        let (least, most) = (limit(f32::min), limit(f32::max));
        let positions = self.accessor(points.iter().flatten().flat_map(|c| c.to_le_bytes()).collect(), 34962);
        self.accessors[positions] = json!({
            "bufferView": positions, "componentType": 5126, "type": "VEC3", "count": points.len(),
            "min": least, "max": most,
        });
        let indices = self.accessor(corners.iter().flat_map(|c| c.to_le_bytes()).collect(), 34963);
        self.accessors[indices] = json!({
            "bufferView": indices, "componentType": 5125, "type": "SCALAR", "count": corners.len(),
        });
        let known = self.materials.iter().position(|one| *one == material);
        let index = known.unwrap_or_else(|| {
            self.materials.push(material);
            self.materials.len() - 1
        });
        json!({ "attributes": { "POSITION": positions }, "indices": indices, "material": index })
    }

    /// Adds bytes with a view of them, and room for their accessor; returns the number of both.
    fn accessor(&mut self, bytes: Vec<u8>, target: u32) -> usize {
        let view = json!({
            "buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len(), "target": target,
        });
        self.views.push(view);
        self.bin.extend(bytes);
        self.accessors.push(serde_json::Value::Null);
        self.accessors.len() - 1
    }
}

/// A material as other programs show it: grey as its reflectivity.
fn material_json(material: Material) -> serde_json::Value {
    let grey = material.reflectivity().clamp(0.0, 1.0);
    json!({
        "name": material.name(),
        "pbrMetallicRoughness": { "baseColorFactor": [grey, grey, grey, 1.0], "metallicFactor": 0.0 },
    })
}
