//! What has changed between visits: a list to decide on.

mod filters;
#[cfg(test)]
mod tests;
mod texts;

use crate::button::Button;
use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::features::imports;
use crate::name_field::NameField;
use crate::select::show_caption;
use crate::widgets::{self, fact};
use crate::{format, icon, screens, theme};
use api::{Command, Import};
use client_model::{CameraMove, ClientCommand, ShownChanges, SiteEdit};
use egui::Ui;
use filters::{Filters, age_s};
use site_model::{Object, ObjectId, ReviewState, SceneChange, SceneChangeId, Utc, Zone, object_history};
use vocab::Stamp;

/// The tab of changes.
const CHANGES: Tab = Tab { screen: screens::RUNS, name: texts::TAB, scrolls: true, row_spacing: 8.0 };
/// Changes that are listed at once.
const MAX_ROWS: usize = 100;

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct ChangesPanel {
    filters: Filters,
    /// The change that is unfolded.
    open: Option<SceneChangeId>,
    reason: NameField,
    comment: NameField,
}

impl FeaturePanel for ChangesPanel {
    fn tabs(&self) -> &'static [Tab] {
        &[CHANGES]
    }

    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let tokens = cx.tokens;
        show_scene_choice(ui, cx);
        widgets::section_head(ui, tokens, texts::HEAD);
        let zones: Vec<&Zone> = cx.model.site.site().into_iter().flat_map(|site| site.zones()).collect();
        let listed = self.filters.show(ui, cx, &zones);
        let all = cx.model.site.site().into_iter().flat_map(|site| site.scene_changes());
        let is_listed = |change: &&SceneChange| self.open == Some(change.id) || listed.admits(change);
        let mut changes: Vec<&SceneChange> = all.clone().filter(is_listed).collect();
        changes.sort_by_key(|change| (-change.last_seen.0, change.id));
        let shown = changes.len().min(MAX_ROWS);
        widgets::remark(ui, tokens, &texts::shown(shown, all.count()));
        imports::show_on_robot(ui, cx);
        if listed.are_acknowledged() {
            let acknowledged: Vec<&SceneChange> = changes
                .iter()
                .copied()
                .filter(|change| change.review == ReviewState::Acknowledged)
                .take(api::MAX_ACCEPTED_CHANGES)
                .collect();
            if let Some(map) = acknowledged.first().map(|change| change.map) {
                let of_map = acknowledged.iter().filter(|change| change.map == map).map(|change| change.id);
                let of_map: Vec<SceneChangeId> = of_map.collect();
                offer_normal(ui, cx, &texts::make_all_normal(of_map.len()), of_map);
            }
        }
        for change in changes.into_iter().take(MAX_ROWS) {
            let is_open = self.open == Some(change.id);
            let row = texts::row(change, age_s(change, cx.clock.utc));
            let button = Button::new(&row).on(is_open).wide(ui).left();
            if ui.push_id(change.id, |ui| button.show(ui, tokens)).inner.clicked() {
                self.open = (!is_open).then_some(change.id);
            }
            if is_open {
                widgets::tinted_box(ui, tokens, tokens.accent, |ui| self.show_change(ui, cx, change));
            }
        }
    }
}

impl ChangesPanel {
    fn show_change(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, change: &SceneChange) {
        let tokens = cx.tokens;
        let first_seen = Stamp::from_nanos(change.first_seen.0);
        fact(ui, tokens, texts::PLACE, &format::position(&change.place.centre_m));
        fact(ui, tokens, texts::SIZE, &texts::size(change));
        fact(ui, tokens, texts::CONFIDENCE, &texts::confidence(change.confidence));
        fact(ui, tokens, texts::FIRST_SEEN, &format::date(first_seen, cx.utc_offset_s));
        fact(ui, tokens, texts::TIMES_SEEN, &format::count(change.times_seen.into()));
        fact(ui, tokens, texts::STATE, &texts::state(&change.review));
        if Button::new(texts::SHOW).icon(icon::EYE).wide(ui).show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::MoveCamera(CameraMove::Point(change.place.centre_m)));
        }
        show_history(ui, cx, change);
        let mut decided = None;
        let reviews = [ReviewState::Acknowledged, ReviewState::Watched];
        let on = reviews.iter().position(|review| change.review == *review);
        widgets::choice(ui, tokens, &texts::DECISIONS, on, |chosen| {
            let review = chosen.filter(|_| chosen != on).map(|index| reviews[index].clone());
            decided = review.map(|review| SceneChange { review, ..change.clone() });
        });
        if !matches!(change.review, ReviewState::Normal { .. }) {
            offer_normal(ui, cx, texts::MAKE_NORMAL, vec![change.id]);
        }
        let object = ObjectId::SceneChange(change.id);
        show_caption(ui, tokens, texts::REASON_FIELD.field);
        if let Some(reason) = self.reason.show(ui, cx, &texts::REASON_FIELD, object, "") {
            decided = Some(SceneChange { review: ReviewState::Dismissed { reason }, ..change.clone() });
        }
        show_caption(ui, tokens, texts::COMMENT_FIELD.field);
        if let Some(comment) = self.comment.show(ui, cx, &texts::COMMENT_FIELD, object, &change.comment) {
            decided = Some(SceneChange { comment, ..change.clone() });
        }
        if let Some(decided) = decided {
            let put = vec![Object::SceneChange(decided)];
            cx.commands.push(ClientCommand::EditSite(SiteEdit { put, removed: Vec::new() }));
        }
    }
}

/// Where the thing of a change was, if that is more than the change says.
fn show_history(ui: &mut Ui, cx: &mut PanelContext<'_>, change: &SceneChange) {
    let (tokens, model) = (cx.tokens, cx.model);
    let (Some(thing), Some(site)) = (change.physical_object, model.site.site()) else { return };
    let is_of_thing =
        |other: &&SceneChange| other.physical_object.is_some_and(|object| object.id == thing.id);
    let stays = object_history(site.scene_changes().filter(is_of_thing));
    if stays.len() < 2 {
        return;
    }
    fact(ui, tokens, texts::SAME_THING, &texts::confidence(thing.probability));
    widgets::remark(ui, tokens, texts::HISTORY_HINT);
    for (number, stay) in (1..).zip(&stays) {
        let date = |at: Utc| format::date(Stamp::from_nanos(at.0), cx.utc_offset_s);
        let place = format::position(&stay.place.centre_m);
        fact(ui, tokens, &place, &texts::stay(stay.from.map(date), stay.until.map(date)));
        let show = texts::show_stay(number);
        if Button::new(&show).icon(icon::EYE).wide(ui).show(ui, tokens).clicked() {
            cx.commands.push(ClientCommand::MoveCamera(CameraMove::Point(stay.place.centre_m)));
        }
    }
}

/// Whose objects are shown in the scene.
fn show_scene_choice(ui: &mut Ui, cx: &mut PanelContext<'_>) {
    let (tokens, shown) = (cx.tokens, cx.model.changes_view.shown());
    let on = match shown {
        ShownChanges::Both => 0,
        ShownChanges::Before => 1,
        ShownChanges::After => 2,
        ShownChanges::Wipe(_) => 3,
    };
    let mut show = |shown| cx.commands.push(ClientCommand::ShowChanges(shown));
    widgets::choice(ui, tokens, &texts::SHOWN, on, |on| {
        show([ShownChanges::Both, ShownChanges::Before, ShownChanges::After, ShownChanges::Wipe(0.5)][on]);
    });
    if let ShownChanges::Wipe(mut share) = shown {
        ui.spacing_mut().slider_width = ui.available_width();
        ui.spacing_mut().interact_size.y = theme::TOUCH;
        let response = ui.add(egui::Slider::new(&mut share, 0.0..=1.0).show_value(false));
        ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(texts::WIPE));
        if response.changed() {
            show(ShownChanges::Wipe(share));
        }
    }
    widgets::remark(ui, tokens, texts::SHOWN_HINT);
}

/// The button that makes changes normal.
fn offer_normal(ui: &mut Ui, cx: &mut PanelContext<'_>, name: &str, changes: Vec<SceneChangeId>) {
    let model = cx.model;
    let is_asked = model.is_pending(|command| matches!(command, Command::MakeNormal { .. }));
    let is_busy = matches!(model.imports.import(), Import::Running { .. });
    let enabled = model.is_connected() && !is_asked && !is_busy;
    let button = Button::new(name).icon(icon::MAP_TRIFOLD).enabled(enabled).hint(texts::NORMAL_HINT);
    if button.wide(ui).show(ui, cx.tokens).clicked() {
        cx.commands.push(ClientCommand::MakeNormal(changes));
    }
}
