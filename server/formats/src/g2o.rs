//! Pose graphs in g2o's text format, SE(3) and SE(2).
//!
//! Information matrices are in the platform's order, `[rotation; translation]`; g2o's files have translation
//! first. The parametrisation of a file's SE(3) information is not written in it: see [`Information`].

use crate::{FormatError, texts};
use std::io::{self, Write};
use vocab::{Pose, Quat, Vec3};

/// A pose of the graph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct G2oVertex<P> {
    /// Its number in the file.
    pub id: u64,
    /// Its pose in the map.
    pub pose: P,
}

/// A measured relative pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct G2oEdge<P, const N: usize> {
    /// Parent vertex.
    pub from: u64,
    /// Child vertex.
    pub to: u64,
    /// Child in the parent.
    pub from_from_to: P,
    /// Inverse covariance.
    pub information: [[f64; N]; N],
}

/// A pose in the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlanarPose {
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Radians, counter-clockwise.
    pub yaw: f64,
}

/// The content of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct G2oGraph {
    /// SE(3) poses.
    pub vertices: Vec<G2oVertex<Pose>>,
    /// SE(3) edges, information as `[rotation; translation]`.
    pub edges: Vec<G2oEdge<Pose, 6>>,
    /// SE(2) poses.
    pub planar_vertices: Vec<G2oVertex<PlanarPose>>,
    /// SE(2) edges, information as `[x, y, yaw]`.
    pub planar_edges: Vec<G2oEdge<PlanarPose, 3>>,
    /// Vertices that the file holds fixed.
    pub fixed: Vec<u64>,
}

/// Parametrisation of the rotational part of an SE(3) edge's information matrix. A file does not say which it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Information {
    /// The error's rotation vector, radians: GTSAM's reading, and that of most published optima.
    #[default]
    RotationVector,
    /// The vector part of the error's quaternion, which is half the rotation vector for small errors: g2o's own reading. The
    /// platform's matrices are of the rotation vector (docs/maths/factors.md, equation 6), so rotational rows and columns are halved on the way in and doubled on the
    /// way out; exact up to third order in the error's angle.
    HalfAngle,
}

impl Information {
    /// By how much a rotational row or column grows on the way in.
    const fn scale(self) -> f64 {
        match self {
            Self::RotationVector => 1.0,
            Self::HalfAngle => 0.5,
        }
    }
}

const WHAT: &str = "g2o graph";
/// Indices of the platform's `[rotation; translation]` in g2o's order.
const G2O_INDEX: [usize; 6] = [3, 4, 5, 0, 1, 2];

/// Reads a graph whose information is of the rotation vector. Kinds of vertices and edges other than poses are refused.
///
/// # Errors
/// When a line is not understood.
pub fn read(text: &str) -> Result<G2oGraph, FormatError> {
    read_as(text, Information::RotationVector)
}

/// Reads a graph. Kinds of vertices and edges other than poses are refused; blank lines and comments are skipped.
///
/// # Errors
/// When a line is not understood.
pub fn read_as(text: &str, convention: Information) -> Result<G2oGraph, FormatError> {
    let mut graph = G2oGraph::default();
    let is_data = |line: &&str| !line.is_empty() && !line.starts_with('#');
    for (index, line) in text.lines().enumerate().filter(|(_, line)| is_data(&line.trim())) {
        let mut words = Words { words: line.split_whitespace(), line: index + 1 };
        match words.next_word()? {
            "VERTEX_SE3:QUAT" => {
                graph.vertices.push(G2oVertex { id: words.id()?, pose: pose(words.numbers()?) });
            }
            "VERTEX_SE2" => {
                let (id, [x, y, yaw]) = (words.id()?, words.numbers()?);
                graph.planar_vertices.push(G2oVertex { id, pose: PlanarPose { x, y, yaw } });
            }
            "EDGE_SE3:QUAT" => {
                let (from, to, measured) = (words.id()?, words.id()?, words.numbers()?);
                let stored: [[f64; 6]; 6] = symmetric(words.numbers::<21>()?);
                let ordered = G2O_INDEX.map(|row| G2O_INDEX.map(|column| stored[row][column]));
                let information = scaled(ordered, convention.scale());
                graph.edges.push(G2oEdge { from, to, from_from_to: pose(measured), information });
            }
            "EDGE_SE2" => {
                let (from, to, [x, y, yaw]) = (words.id()?, words.id()?, words.numbers()?);
                let information = symmetric(words.numbers::<6>()?);
                graph.planar_edges.push(G2oEdge {
                    from,
                    to,
                    from_from_to: PlanarPose { x, y, yaw },
                    information,
                });
            }
            "FIX" => graph.fixed.push(words.id()?),
            other => {
                let problem = texts::unknown_graph_element(other);
                return Err(FormatError::at_line(WHAT, index + 1, problem));
            }
        }
    }
    Ok(graph)
}

/// Writes SE(3) vertices and edges, information of the rotation vector.
///
/// # Errors
/// When `out` fails.
pub fn write(
    out: &mut impl Write,
    vertices: &[G2oVertex<Pose>],
    edges: &[G2oEdge<Pose, 6>],
) -> io::Result<()> {
    write_space(out, vertices, edges, Information::RotationVector)
}

/// Writes a whole graph.
///
/// # Errors
/// When `out` fails.
pub fn write_as(out: &mut impl Write, graph: &G2oGraph, convention: Information) -> io::Result<()> {
    for G2oVertex { id, pose } in &graph.planar_vertices {
        writeln!(out, "VERTEX_SE2 {id} {} {} {}", pose.x, pose.y, pose.yaw)?;
    }
    for G2oEdge { from, to, from_from_to: pose, information } in &graph.planar_edges {
        write!(out, "EDGE_SE2 {from} {to} {} {} {}", pose.x, pose.y, pose.yaw)?;
        write_upper(out, information)?;
    }
    write_space(out, &graph.vertices, &graph.edges, convention)?;
    graph.fixed.iter().try_for_each(|id| writeln!(out, "FIX {id}"))
}

fn write_space(
    out: &mut impl Write,
    vertices: &[G2oVertex<Pose>],
    edges: &[G2oEdge<Pose, 6>],
    convention: Information,
) -> io::Result<()> {
    for vertex in vertices {
        write!(out, "VERTEX_SE3:QUAT {}", vertex.id)?;
        write_pose(out, &vertex.pose)?;
        writeln!(out)?;
    }
    for edge in edges {
        write!(out, "EDGE_SE3:QUAT {} {}", edge.from, edge.to)?;
        write_pose(out, &edge.from_from_to)?;
        let information = scaled(edge.information, 1.0 / convention.scale());
        // The permutation swaps halves, so it is its own inverse.
        write_upper(out, &G2O_INDEX.map(|row| G2O_INDEX.map(|column| information[row][column])))?;
    }
    Ok(())
}

/// The upper triangle, row by row, and the end of the line.
fn write_upper<const N: usize>(out: &mut impl Write, matrix: &[[f64; N]; N]) -> io::Result<()> {
    for (row, values) in matrix.iter().enumerate() {
        for value in &values[row..] {
            write!(out, " {value}")?;
        }
    }
    writeln!(out)
}

/// Rotational rows and columns times `scale`.
fn scaled(mut information: [[f64; 6]; 6], scale: f64) -> [[f64; 6]; 6] {
    for (row, values) in information.iter_mut().enumerate() {
        for (column, value) in values.iter_mut().enumerate() {
            *value *= if row < 3 { scale } else { 1.0 } * if column < 3 { scale } else { 1.0 };
        }
    }
    information
}

fn write_pose(out: &mut impl Write, pose: &Pose) -> io::Result<()> {
    let (p, q) = (pose.position, pose.orientation);
    write!(out, " {} {} {} {} {} {} {}", p.x, p.y, p.z, q.x, q.y, q.z, q.w)
}

fn pose([x, y, z, qx, qy, qz, qw]: [f64; 7]) -> Pose {
    Pose { position: Vec3::new(x, y, z), orientation: Quat { w: qw, x: qx, y: qy, z: qz } }
}

/// A symmetric matrix from its upper triangle, row by row.
fn symmetric<const N: usize, const T: usize>(upper: [f64; T]) -> [[f64; N]; N] {
    let mut matrix = [[0.0; N]; N];
    let mut values = upper.into_iter();
    for row in 0..N {
        for column in row..N {
            let value = values.next().unwrap_or_default();
            matrix[row][column] = value;
            matrix[column][row] = value;
        }
    }
    matrix
}

struct Words<'a> {
    words: std::str::SplitWhitespace<'a>,
    line: usize,
}

impl<'a> Words<'a> {
    fn next_word(&mut self) -> Result<&'a str, FormatError> {
        self.words.next().ok_or_else(|| FormatError::at_line(WHAT, self.line, texts::LINE_ENDS_EARLY))
    }

    fn id(&mut self) -> Result<u64, FormatError> {
        let word = self.next_word()?;
        let problem = || texts::not_a_vertex(word);
        word.parse().map_err(|_| FormatError::at_line(WHAT, self.line, problem()))
    }

    fn numbers<const N: usize>(&mut self) -> Result<[f64; N], FormatError> {
        let mut values = [0.0; N];
        for value in &mut values {
            let word = self.next_word()?;
            let problem = || texts::not_a_number(word);
            *value = word.parse().map_err(|_| FormatError::at_line(WHAT, self.line, problem()))?;
        }
        Ok(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_exactly() {
        let pose = pose([0.1, -2.0, 1e-7, 0.5, 0.5, -0.5, 0.5]);
        let mut information = [[0.0; 6]; 6];
        for (i, row) in information.iter_mut().enumerate() {
            for (j, value) in row.iter_mut().enumerate() {
                *value = 1.0 / (1 + i.min(j) * 6 + i.max(j)) as f64;
            }
        }
        let vertices = [G2oVertex { id: 0, pose }, G2oVertex { id: 7, pose }];
        let edges = [G2oEdge { from: 0, to: 7, from_from_to: pose, information }];
        let mut text = Vec::new();
        write(&mut text, &vertices, &edges).unwrap();
        let text = String::from_utf8(text).unwrap();
        let graph = read(&text).unwrap();
        assert_eq!((graph.vertices.as_slice(), graph.edges.as_slice()), (&vertices[..], &edges[..]));
        // g2o's first information number belongs to x.
        assert!(text.contains(&format!(" {} ", information[3][3])));
    }

    #[test]
    fn both_conventions_name_the_same_graph() {
        let text = "VERTEX_SE3:QUAT 3 1 2 3 0 0 0 1\nEDGE_SE3:QUAT 3 4 0 0 0 0 0 0 1 \
            1 0 0 8 0 0 1 0 0 0 0 1 0 0 0 4 0 0 4 0 4\nVERTEX_SE2 7 1 2 3\nEDGE_SE2 7 8 1 0 0 1 2 3 4 5 6\nFIX 3\n";
        let graph = read_as(text, Information::HalfAngle).unwrap();
        let information = graph.edges[0].information;
        // Half the angle, so a quarter of the information; the coupling of x and the first angle is halved.
        assert_eq!((information[0][0], information[3][3], information[0][3]), (1.0, 1.0, 4.0));
        for convention in [Information::HalfAngle, Information::RotationVector] {
            let mut out = Vec::new();
            write_as(&mut out, &graph, convention).unwrap();
            let again = String::from_utf8(out).unwrap();
            assert_eq!(read_as(&again, convention).unwrap(), graph);
        }
        assert_ne!(read(text).unwrap(), graph);
    }

    #[test]
    fn planar_graphs_and_bad_lines() {
        let graph = read("VERTEX_SE2 0 1 2 3\n\nEDGE_SE2 0 1 1 0 0 1 2 3 4 5 6\nFIX 0\n").unwrap();
        assert_eq!(graph.planar_edges[0].information, [[1.0, 2.0, 3.0], [2.0, 4.0, 5.0], [3.0, 5.0, 6.0]]);
        assert_eq!(graph.fixed, [0]);
        let error = read("VERTEX_SE2 0 1 2\n").unwrap_err().to_string();
        assert!(error.contains("line 1"), "{error}");
        assert!(read("VERTEX_XY 0 1 2").is_err());
    }
}
