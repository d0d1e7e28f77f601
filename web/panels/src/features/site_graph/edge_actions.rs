//! What is done along an edge: actions before the robot sets out, while it walks, and after it has arrived.

use super::moment::EdgeActionTime;
use super::texts;
use crate::button::{Button, Kind};
use crate::feature_panel::PanelContext;
use crate::features::action_form::{TypedParameters, action_title};
use crate::select::select;
use crate::theme;
use crate::{icon, widgets};
use egui::{Id, Ui};
use site_model::{ActionRequest, Edge, EdgeId, Parameters, actions_at_places};

/// What the section keeps between frames.
#[derive(Debug, Default)]
pub(super) struct EdgeActions {
    /// The action whose form is unfolded, by its place in its list.
    open: Option<(EdgeId, EdgeActionTime, usize)>,
    typed: TypedParameters,
}

impl EdgeActions {
    /// Shows the three lists. Returns one of them once it is changed.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        edge: &Edge,
    ) -> Option<(EdgeActionTime, Vec<ActionRequest>)> {
        widgets::section_head(ui, cx.tokens, texts::ACTIONS_HEAD);
        let mut changed = None;
        for (moment, caption) in texts::MOMENTS {
            let list = self.show_list(ui, cx, edge, moment, caption);
            changed = changed.or(list.map(|list| (moment, list)));
        }
        changed
    }

    fn show_list(
        &mut self,
        ui: &mut Ui,
        cx: &mut PanelContext<'_>,
        edge: &Edge,
        moment: EdgeActionTime,
        caption: &str,
    ) -> Option<Vec<ActionRequest>> {
        let tokens = cx.tokens;
        let mut changed = None;
        let titles: Vec<String> = actions_at_places().iter().map(|action| action.title.to_owned()).collect();
        let name = texts::add_action(caption);
        if let Some(index) = select(ui, tokens, &name, caption, texts::ADD_ACTION, &titles) {
            let action = actions_at_places()[index].name.to_owned();
            let mut list = moment.actions(edge).clone();
            list.push(ActionRequest { action, parameters: Parameters::new() });
            self.open = Some((edge.id, moment, list.len() - 1));
            changed = Some(list);
        }
        for (index, request) in moment.actions(edge).iter().enumerate() {
            let place = (edge.id, moment, index);
            let title = action_title(&request.action);
            let name = texts::action_row(caption, index + 1, &title);
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing.x = 4.0;
                let width = ui.available_width() - theme::TOUCH - 4.0;
                let row = Button::new(&name).text(&title).on(self.open == Some(place)).left();
                if row.size(width, theme::TOUCH).show(ui, tokens).clicked() {
                    self.open = if self.open == Some(place) { None } else { Some(place) };
                }
                let remove = texts::remove_row(&name);
                if Button::icon_only(&remove, icon::X).kind(Kind::Quiet).show(ui, tokens).clicked() {
                    let mut list = moment.actions(edge).clone();
                    list.remove(index);
                    self.open = None;
                    changed = Some(list);
                }
            });
            if self.open == Some(place) {
                let owner = Id::unique(("action of edge", edge.id.0, moment, index));
                self.typed.keep_only(owner);
                if cx.model.site.action_forms().fields(&request.action).is_empty() {
                    widgets::remark(ui, tokens, texts::NO_PARAMETERS);
                }
                if let Some(parameters) = self.typed.show(ui, cx, owner, request, false) {
                    let mut list = moment.actions(edge).clone();
                    list[index].parameters = parameters;
                    changed = Some(list);
                }
            }
        }
        changed
    }
}
