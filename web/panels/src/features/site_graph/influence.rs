//! Where the robot counts as at a node: within the tolerance, and in an area if the node has one.

use super::texts;
use crate::feature_panel::PanelContext;
use crate::number_field::TypedNumber;
use crate::{corner_fields, widgets};
use egui::Ui;
use site_model::{Node, ObjectId};

/// What an area begins with.
#[derive(Clone, Copy, Debug)]
struct NewAreaConfig {
    /// Half of the side of the square round the node, metres. Chosen: the robot, which is a metre long, is at the node while it stands on it.
    half_side_m: f64,
}

const NEW: NewAreaConfig = NewAreaConfig { half_side_m: 0.5 };

/// Shows whether there is an area, and its corners of the area. Returns other corners once they are changed; without any, the tolerance alone counts.
pub(super) fn show(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    typed: &mut TypedNumber,
    node: &Node,
) -> Option<Vec<[f64; 2]>> {
    let tokens = cx.tokens;
    widgets::section_head(ui, tokens, texts::INFLUENCE_HEAD);
    let has_area = !node.influence_area_m.is_empty();
    let mut chosen = has_area;
    widgets::choice(ui, tokens, &texts::INFLUENCES, has_area, |area| chosen = area);
    if chosen != has_area {
        let half = NEW.half_side_m;
        let square = vec![[half, half], [-half, half], [-half, -half], [half, -half]];
        return Some(if chosen { square } else { Vec::new() });
    }
    widgets::remark(ui, tokens, texts::influence_remark(has_area));
    if !has_area {
        return None;
    }
    corner_fields::show(ui, cx, typed, ObjectId::Node(node.id), &node.influence_area_m)
}
