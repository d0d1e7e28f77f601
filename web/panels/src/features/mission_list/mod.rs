//! The list of missions: search, new, open, duplicate, delete.

#[cfg(test)]
mod tests;
mod texts;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext};
use crate::features::mission_task::push_edit;
use crate::features::tabs;
use crate::paint::{focus_ring, icon_at, line_at};
use crate::theme::{self, Weight};
use crate::{TextInput, TextInputKind, icon, screens, widgets};
use client_model::{ClientCommand, MissionEditorCommand, users_of_mission};
use egui::{CornerRadius, Role, ScrollArea, Sense, StrokeKind, Ui, WidgetInfo, pos2, vec2};
use site_model::{Mission, MissionId, ObjectId, Site, TaskPlace};

/// Parameters of the list.
struct MissionListConfig {
    /// Missions from which on the list has a search. Chosen: more rows do not fit beside the other cards.
    search_from: usize,
}

const CONFIG: MissionListConfig = MissionListConfig { search_from: 6 };

/// Height of a row, points.
const ROW_HEIGHT: f32 = 56.0;

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct MissionListPanel {
    search: String,
    /// The mission of which the operator is asked to confirm the deletion.
    deletion: Option<MissionId>,
}

impl FeaturePanel for MissionListPanel {
    fn cancel(&mut self, _cx: &mut PanelContext<'_>) -> bool {
        self.deletion.take().is_some()
    }

    fn tabs(&self) -> &'static [crate::feature_panel::Tab] {
        &[tabs::MISSIONS]
    }

    fn show_section(&mut self, _tab: crate::feature_panel::Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        if cx.model.missions.open().is_some() {
            return;
        }
        let tokens = cx.tokens;
        widgets::head(ui, tokens, texts::HEAD);
        let Some(site) = cx.model.site.site() else { return widgets::remark(ui, tokens, texts::LOADING) };
        let mut missions: Vec<&Mission> = site.missions().collect();
        missions.sort_by_key(|mission| mission.name.to_lowercase());
        self.show_top(ui, cx, site, missions.len());
        let wanted = self.search.trim().to_lowercase();
        let is_searched = missions.len() >= CONFIG.search_from;
        missions.retain(|mission| !is_searched || mission.name.to_lowercase().contains(&wanted));
        if missions.is_empty() && !wanted.is_empty() {
            widgets::remark(ui, tokens, texts::NOTHING);
        }
        let height = (ui.available_height() - theme::TOUCH - 8.0).max(ROW_HEIGHT);
        let area = ScrollArea::vertical().id_salt(texts::HEAD).auto_shrink([false, false]).max_height(height);
        area.show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 8.0;
            for mission in missions {
                ui.push_id(mission.id.0, |ui| self.show_mission(ui, cx, site, mission));
            }
        });
        show_files(ui, cx);
    }
}

impl MissionListPanel {
    /// What there is to do without a list: making one; and the search of a long one.
    fn show_top(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, count: usize) {
        let tokens = cx.tokens;
        if site.nodes().next().is_none() {
            widgets::sentence(ui, tokens, texts::NO_NODES);
            if Button::new(texts::TO_SITE).icon(icon::GRAPH).wide(ui).show(ui, tokens).clicked() {
                cx.commands.push(ClientCommand::ShowScreen(screens::SITE));
            }
        } else {
            if count == 0 {
                widgets::sentence(ui, tokens, texts::NONE);
            }
            let kind = if count == 0 { Kind::Primary } else { Kind::Plain };
            if Button::new(texts::NEW).icon(icon::PLUS).kind(kind).wide(ui).show(ui, tokens).clicked() {
                let (mission, edit) = cx.model.site.adding_mission();
                push_edit(cx, edit);
                open(cx, mission);
            }
        }
        if count >= CONFIG.search_from {
            let search = TextInput::new(texts::SEARCH, texts::SEARCH).hint(texts::SEARCH_HINT);
            search.kind(TextInputKind::Search).show(ui, tokens, cx.text_inputs, &mut self.search);
        }
    }

    fn show_mission(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, mission: &Mission) {
        let tokens = cx.tokens;
        let (schedules, monitors) = users_of_mission(site, mission.id);
        let name = if mission.name.trim().is_empty() { texts::UNNAMED } else { mission.name.trim() };
        let broken = mission.tasks.iter().filter(|task| is_broken(site, &task.place)).count();
        if show_row(ui, cx, name, mission.tasks.len(), broken, &schedules) {
            open(cx, mission.id);
        }
        if self.deletion == Some(mission.id) {
            cx.frame.is_escape_consumed = true;
            widgets::tinted_box(ui, tokens, tokens.bad, |ui| {
                widgets::sentence(ui, tokens, &texts::deletion(name, &schedules, &monitors));
                ui.horizontal(|ui| {
                    let width = half_width(ui);
                    let sure = texts::delete_for_sure(name, schedules.len());
                    let delete =
                        Button::new(&sure).text(texts::DELETE_SHORT).icon(icon::TRASH).kind(Kind::Danger);
                    if delete.slim().size(width, theme::TOUCH).show(ui, tokens).clicked() {
                        push_edit(cx, cx.model.site.removing_mission(mission.id));
                        self.deletion = None;
                    }
                    let keep =
                        Button::new(texts::KEEP_NAME).text(texts::KEEP).slim().size(width, theme::TOUCH);
                    if keep.show(ui, tokens).clicked() {
                        self.deletion = None;
                    }
                });
            });
            return;
        }
        ui.horizontal(|ui| {
            let width = half_width(ui);
            let text = texts::duplicate(name);
            let copy =
                Button::new(&text).text(texts::DUPLICATE_SHORT).icon(icon::COPY).kind(Kind::Quiet).slim();
            if copy.size(width, 32.0).show(ui, tokens).clicked()
                && let Some((copy, edit)) = cx.model.site.duplicating_mission(mission.id)
            {
                push_edit(cx, edit);
                open(cx, copy);
            }
            let text = texts::delete(name);
            let delete =
                Button::new(&text).text(texts::DELETE_SHORT).icon(icon::TRASH).kind(Kind::Quiet).slim();
            if delete.size(width, 32.0).show(ui, tokens).clicked() {
                // Without anything that depends on it, an undo is enough.
                if schedules.is_empty() && monitors.is_empty() {
                    push_edit(cx, cx.model.site.removing_mission(mission.id));
                } else {
                    self.deletion = Some(mission.id);
                }
            }
        });
    }
}

/// Missions and schedules as a file of the operator's machine.
fn show_files(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    ui.horizontal(|ui| {
        let width = half_width(ui);
        let buttons = [
            (texts::SAVE, texts::SAVE_SHORT, icon::DOWNLOAD_SIMPLE, ClientCommand::SavePlanFile),
            (texts::LOAD, texts::LOAD_SHORT, icon::UPLOAD_SIMPLE, ClientCommand::LoadPlanFile),
        ];
        for (name, text, sign, command) in buttons {
            let button = Button::new(name).text(text).icon(sign).slim().size(width, theme::TOUCH);
            if button.show(ui, cx.tokens).clicked() {
                cx.commands.push(command);
            }
        }
    });
}

/// Whether the site lacks a place.
fn is_broken(site: &Site, place: &TaskPlace) -> bool {
    let object = match place {
        TaskPlace::InspectionPoint(point) => ObjectId::InspectionPoint(*point),
        TaskPlace::Node { node, .. } => ObjectId::Node(*node),
    };
    site.get(object).is_none()
}

fn open(cx: &mut PanelContext<'_>, mission: MissionId) {
    cx.commands.push(ClientCommand::MissionEditor(MissionEditorCommand::Open(Some(mission))));
}

/// The row of a mission. Returns whether it was pressed.
fn show_row(
    ui: &mut Ui,
    cx: &PanelContext<'_>,
    name: &str,
    tasks: usize,
    broken: usize,
    schedules: &[&str],
) -> bool {
    let tokens = cx.tokens;
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), ROW_HEIGHT), Sense::click());
    let label = texts::open(name);
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &label));
    let radius = CornerRadius::same(theme::BUTTON_RADIUS);
    let fill = if response.hovered() { tokens.hovered(tokens.raised) } else { tokens.raised };
    ui.painter().rect(rect, radius, fill, tokens.border(), StrokeKind::Inside);
    if response.has_focus() {
        focus_ring(ui, rect.shrink(2.0), tokens);
    }
    icon_at(ui, pos2(rect.left() + 24.0, rect.center().y), icon::LIST_CHECKS, 20.0, tokens.accent);
    let (left, width) = (rect.left() + 48.0, rect.width() - 60.0);
    let top = pos2(left, rect.center().y - 10.0);
    line_at(ui, top, width, name, (theme::BODY, Weight::Medium), tokens.text);
    let (note, colour) = match broken {
        0 => (texts::summary(tasks, None, schedules), tokens.dim),
        count => (texts::problems(count), tokens.bad),
    };
    line_at(ui, pos2(left, rect.center().y + 10.0), width, &note, (theme::SMALL, Weight::Regular), colour);
    response.clicked()
}

/// Width of each of two buttons side by side.
fn half_width(ui: &mut Ui) -> f32 {
    let gap = 8.0;
    ui.spacing_mut().item_spacing.x = gap;
    ((ui.available_width() - gap) / 2.0).floor()
}
