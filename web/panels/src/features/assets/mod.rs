//! Assets: the things that are inspected, with their tags and the inspection points that look at them.

#[cfg(test)]
mod tests;
mod texts;

use crate::button::{Button, Kind};
use crate::feature_panel::{FeaturePanel, PanelContext, Tab};
use crate::name_field::NameField;
use crate::tag_field::TagField;
use crate::{TextInput, TextInputKind, icon, screens, widgets};
use client_model::{ClientCommand, Selection, SiteEdit};
use egui::Ui;
use site_model::{Asset, AssetId, ObjectId};

/// The tab of assets.
const ASSETS: Tab = Tab { screen: screens::SITE, name: texts::TAB, scrolls: true, row_spacing: 8.0 };

/// When the list has a search.
struct AssetListConfig {
    /// Assets from which on they are searched. Chosen: fewer are seen at once.
    min_searched: usize,
}

const CONFIG: AssetListConfig = AssetListConfig { min_searched: 8 };

/// What the panel keeps between frames.
#[derive(Debug, Default)]
pub(crate) struct AssetsPanel {
    /// The asset whose form is unfolded.
    open: Option<AssetId>,
    name: NameField,
    tags: TagField,
    /// What is typed to find an asset.
    search: String,
}

impl FeaturePanel for AssetsPanel {
    fn tabs(&self) -> &'static [Tab] {
        &[ASSETS]
    }

    fn show_section(&mut self, _tab: Tab, ui: &mut Ui, cx: &mut PanelContext<'_>) {
        let (model, tokens) = (cx.model, cx.tokens);
        widgets::section_head(ui, tokens, texts::HEAD);
        if model.site.site().is_none() {
            return widgets::remark(ui, tokens, texts::LOADING);
        }
        if Button::new(texts::ADD).icon(icon::PLUS).wide(ui).show(ui, tokens).clicked() {
            let (asset, edit) = model.site.adding_asset();
            self.open = Some(asset);
            self.search.clear();
            cx.commands.push(ClientCommand::EditSite(edit));
        }
        let assets = model.site.assets();
        if assets.is_empty() {
            return widgets::remark(ui, tokens, texts::EMPTY);
        }
        if assets.len() >= CONFIG.min_searched {
            let field = TextInput::new("find asset", texts::FIND).hint(texts::FIND_HINT);
            field.kind(TextInputKind::Search).show(ui, tokens, cx.text_inputs, &mut self.search);
        }
        let wanted = self.search.trim().to_lowercase();
        for asset in assets.into_iter().filter(|asset| matches(asset, &wanted)) {
            let is_open = self.open == Some(asset.id);
            let name = texts::asset(&asset.name);
            let row = texts::row(asset, model.site.points_of_asset(asset.id).len());
            let button = Button::new(&name).text(&row).on(is_open).wide(ui).left();
            if button.show(ui, tokens).clicked() {
                self.open = (!is_open).then_some(asset.id);
            }
            if is_open {
                widgets::tinted_box(ui, tokens, tokens.accent, |ui| self.show_asset(ui, cx, asset));
            }
        }
    }
}

/// Whether the name or a tag of an asset has this in it, in any case.
fn matches(asset: &Asset, wanted: &str) -> bool {
    let mut words = std::iter::once(&asset.name).chain(&asset.tags);
    words.any(|word| word.to_lowercase().contains(wanted))
}

impl AssetsPanel {
    fn show_asset(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, asset: &Asset) {
        let (model, tokens) = (cx.model, cx.tokens);
        let object = ObjectId::Asset(asset.id);
        if let Some(name) = self.name.show(ui, cx, &texts::NAME_FIELD, object, &asset.name) {
            change(cx, model.site.changing_asset(asset.id, |asset| asset.name = name));
        }
        if let Some(tags) = self.tags.show(ui, cx, object, &asset.tags) {
            change(cx, model.site.changing_asset(asset.id, |asset| asset.tags = tags));
        }
        let points = model.site.points_of_asset(asset.id);
        widgets::remark(ui, tokens, if points.is_empty() { texts::NO_POINTS } else { texts::POINTS });
        for point in points {
            let name = texts::select_point(&point.name);
            let button = Button::new(&name).text(&point.name).icon(icon::CAMERA).kind(Kind::Quiet);
            if button.wide(ui).left().show(ui, tokens).clicked() {
                let selection = Some(Selection::InspectionPoint(point.id));
                cx.commands.push(ClientCommand::Select(selection));
            }
        }
        let name = texts::delete(&asset.name);
        let delete = Button::new(&name).text(texts::DELETE_SHORT).icon(icon::TRASH).kind(Kind::Danger);
        if delete.wide(ui).show(ui, tokens).clicked() {
            self.open = None;
            change(cx, model.site.removing_asset(asset.id));
        }
    }
}

/// Emits an edit, unless it changes nothing.
fn change(cx: &mut PanelContext<'_>, edit: SiteEdit) {
    if edit != SiteEdit::default() {
        cx.commands.push(ClientCommand::EditSite(edit));
    }
}
