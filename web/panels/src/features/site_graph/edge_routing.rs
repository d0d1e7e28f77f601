//! How routes count an edge: its cost, and the group of edges that one robot uses at a time.

use super::texts;
use crate::feature_panel::PanelContext;
use crate::number_field::{NumberField, TypedNumber};
use crate::select::show_caption;
use crate::{TextInput, widgets};
use egui::Ui;
use site_model::{Edge, EdgeCost, EdgeId, ObjectId};

/// Times of an edge that people may enter, seconds. Chosen: up to a day, as for a lift that is seldom free.
const TIMES_S: [f64; 2] = [0.0, 86_400.0];
/// Time that an edge has when people begin to say it, seconds. Chosen.
const NEW_TIME_S: f64 = 10.0;
/// Longest name of a group, characters. Chosen: it fits its field.
const GROUP_CHARS: u32 = 40;

/// What is typed of the group of an edge.
#[derive(Debug, Default)]
pub(super) struct GroupField {
    typed: Option<(EdgeId, String)>,
}

/// Shows what an edge costs. Returns another cost once it is chosen.
pub(super) fn show_cost(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    typed: &mut TypedNumber,
    edge: &Edge,
) -> Option<EdgeCost> {
    widgets::section_head(ui, cx.tokens, texts::COST_HEAD);
    let time_s = match edge.cost {
        EdgeCost::Fixed(time_s) => time_s,
        EdgeCost::Length | EdgeCost::Learned => NEW_TIME_S,
    };
    let costs = [EdgeCost::Length, EdgeCost::Learned, EdgeCost::Fixed(time_s)];
    let choices: Vec<(&str, EdgeCost)> = texts::COSTS.into_iter().zip(costs).collect();
    let mut cost = edge.cost;
    widgets::choice(ui, cx.tokens, &choices, edge.cost, |chosen| cost = chosen);
    widgets::remark(ui, cx.tokens, texts::cost_remark(edge.cost));
    if let EdgeCost::Fixed(value) = edge.cost {
        let (name, object) = (texts::COST_TIME, ObjectId::Edge(edge.id));
        let field = NumberField {
            name,
            object,
            value: Some(value),
            hint: "",
            step: 5.0,
            decimals: 1,
            range: TIMES_S,
        };
        if let Some(time_s) = field.show(ui, cx, typed).flatten() {
            cost = EdgeCost::Fixed(time_s);
        }
    }
    (cost != edge.cost).then_some(cost)
}

impl GroupField {
    /// Shows the group. Returns another one, or none, once it is typed.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        edge: &Edge,
    ) -> Option<Option<String>> {
        let present = edge.mutex_group.as_deref().unwrap_or_default();
        let of_edge = self.typed.take().filter(|(of, _)| *of == edge.id);
        let mut text = of_edge.map_or_else(|| present.to_owned(), |(_, text)| text);
        show_caption(ui, cx.tokens, texts::MUTEX_GROUP);
        let input = TextInput::new(("mutex group", edge.id.0), texts::MUTEX_GROUP).hint(texts::NO_GROUP);
        let response = input.max_length(GROUP_CHARS).show(ui, cx.tokens, cx.text_inputs, &mut text);
        widgets::remark(ui, cx.tokens, texts::MUTEX_REMARK);
        if response.lost_focus || response.submitted {
            let group = text.trim();
            return (group != present).then(|| Some(group.to_owned()).filter(|group| !group.is_empty()));
        }
        self.typed = Some((edge.id, text)).filter(|(_, text)| text != present);
        None
    }
}
