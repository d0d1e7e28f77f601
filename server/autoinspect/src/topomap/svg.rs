//! A picture of a topological map: its floors side by side, seen from above, each with the points of the map near the floor.

use super::ends;
use crate::export::picture::{Heights, MapPicture, Settings};
use crate::failure::Failure;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use site_model::{Node, NodeKind, Traversal};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;
use store::{CloudSelection, map_clouds};
use topomap::GeneratedMap;

/// Fixed parameters of the picture.
struct SvgConfig {
    /// Scale, units for each metre. Chosen: a hall of 60 m fits on a screen of 960 pixels.
    units_per_m: f64,
    /// Edge of a pixel of the points, metres. Chosen: half a column of the ground; smaller ones make larger files.
    pixel_m: f64,
    /// Distance between two floors, units. Chosen: a little more than a metre of the map.
    gap: f64,
    /// Points from this far below the base to this far above it are drawn, metres. Chosen: the height of a base and a margin, so that the floor is drawn.
    below_base_m: f64,
    /// See [`Self::below_base_m`], metres. Chosen: lower than ceilings, and high enough for walls and machines.
    above_base_m: f64,
}

const CONFIG: SvgConfig =
    SvgConfig { units_per_m: 16.0, pixel_m: 0.1, gap: 20.0, below_base_m: 0.8, above_base_m: 1.0 };

/// The picture.
pub fn draw(map: &Path, made: &GeneratedMap) -> Result<String, Failure> {
    let floors: BTreeSet<i32> = made.nodes.iter().map(|node| node.floor).collect();
    let (mut body, mut left, mut height) = (String::new(), 0.0, 0.0_f64);
    for floor in floors {
        let nodes: Vec<&Node> = made.nodes.iter().filter(|node| node.floor == floor).collect();
        let level = nodes.iter().map(|node| node.map_from_node.position.z);
        let (low, high) = level.fold((f64::MAX, f64::MIN), |(low, high), z| (low.min(z), high.max(z)));
        let heights = Heights { from: low - CONFIG.below_base_m, to: high + CONFIG.above_base_m };
        let clouds = map_clouds(map, CloudSelection { spacing_m: 0.05, include_dynamic: false })
            .map_err(Failure::usage)?;
        let settings =
            Settings { pixel: CONFIG.pixel_m, above_robot: CONFIG.above_base_m, heights: Some(heights) };
        let Some(picture) = MapPicture::of(clouds, settings).map_err(Failure::failed)? else { continue };
        let size = draw_floor(&mut body, made, floor, &picture, left)?;
        left += size[0] + CONFIG.gap;
        height = height.max(size[1]);
    }
    let width = (left - CONFIG.gap).max(0.0);
    Ok(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"{width:.0}\" height=\"{height:.0}\" fill=\"#fafaf8\"/>\n{body}</svg>\n"
    ))
}

/// Draws one floor; returns its size.
fn draw_floor(
    body: &mut String,
    made: &GeneratedMap,
    floor: i32,
    picture: &MapPicture,
    left: f64,
) -> Result<[f64; 2], Failure> {
    let mut png = Vec::new();
    picture.write_png(&mut png).map_err(Failure::failed)?;
    let [[x_min, y_min], [x_max, y_max]] = picture.area_m();
    let scale = CONFIG.units_per_m;
    let size = [(x_max - x_min) * scale, (y_max - y_min) * scale];
    let place = |x: f64, y: f64| [left + (x - x_min) * scale, (y_max - y) * scale];
    // Writing to a string cannot fail.
    let _ = writeln!(
        body,
        "<image x=\"{left:.1}\" y=\"0\" width=\"{:.1}\" height=\"{:.1}\" opacity=\"0.5\" href=\"data:image/png;base64,{}\"/>",
        size[0],
        size[1],
        STANDARD.encode(&png)
    );
    let on_floor = |id| made.nodes.iter().any(|node| node.id == id && node.floor == floor);
    for edge in made.edges.iter().filter(|edge| on_floor(edge.from) || on_floor(edge.to)) {
        // One line for both directions.
        let has_reverse = made.edges.iter().any(|other| other.from == edge.to && other.to == edge.from);
        if has_reverse && edge.from > edge.to {
            continue;
        }
        let Some([from, to]) = ends(made, edge) else { continue };
        let ([x1, y1], [x2, y2]) = (place(from.x, from.y), place(to.x, to.y));
        let style = match edge.traversal {
            Traversal::Stairs => "stroke=\"#c2410c\" stroke-dasharray=\"7 4\"",
            Traversal::Dock => "stroke=\"#15803d\"",
            _ => "stroke=\"#1d4ed8\"",
        };
        let _ = writeln!(
            body,
            "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" {style} stroke-width=\"3\"/>"
        );
    }
    for node in made.nodes.iter().filter(|node| node.floor == floor) {
        let [x, y] = place(node.map_from_node.position.x, node.map_from_node.position.y);
        let colour = match node.kind {
            NodeKind::Portal => "#c2410c",
            NodeKind::Dock | NodeKind::DockApproach => "#15803d",
            _ => "#1d4ed8",
        };
        let _ = writeln!(
            body,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"6\" fill=\"{colour}\" stroke=\"#fff\" stroke-width=\"1.5\"><title>{}</title></circle>",
            node.name
        );
    }
    for segment in &made.blocked {
        let [x, y] = place(segment.to_m.x, segment.to_m.y);
        let _ = writeln!(
            body,
            "<path d=\"M{:.1} {:.1} l12 12 m0 -12 l-12 12\" stroke=\"#b91c1c\" stroke-width=\"3\"/>",
            x - 6.0,
            y - 6.0
        );
    }
    let _ = writeln!(body, "<text x=\"{:.1}\" y=\"16\" fill=\"#333\">floor {floor}</text>", left + 6.0);
    Ok(size)
}
