//! The asset that an inspection point belongs to, and the range in which nothing is wrong with its reading.

use super::texts;
use crate::feature_panel::PanelContext;
use crate::number_field::{NumberField, TypedNumber};
use crate::select::select;
use crate::widgets;
use egui::Ui;
use site_model::{AssetId, InspectionPoint, ObjectId, ReadingLimits};

/// Numbers that people may enter as limits.
const RANGE: [f64; 2] = [-1e9, 1e9];
/// Smallest difference of the two limits: the last digit that is shown.
const MIN_RANGE: f64 = 0.01;

/// Shows to which asset a point belongs. Returns another one, or none, once it is chosen.
pub(super) fn show_asset(
    ui: &mut Ui,
    cx: &PanelContext<'_>,
    point: &InspectionPoint,
) -> Option<Option<AssetId>> {
    let assets = cx.model.site.assets();
    if assets.is_empty() {
        return None;
    }
    let mut options = vec![texts::NO_ASSET.to_owned()];
    options.extend(assets.iter().map(|asset| asset.name.clone()));
    let chosen = assets.iter().position(|asset| Some(asset.id) == point.asset).map_or(0, |index| index + 1);
    let index = select(ui, cx.tokens, texts::ASSET, texts::ASSET, &options[chosen], &options)?;
    let asset = index.checked_sub(1).map(|index| assets[index].id);
    (asset != point.asset).then_some(asset)
}

/// Shows the limits of the reading. Returns other ones, or none, once they are changed.
pub(super) fn show(
    ui: &mut Ui,
    cx: &mut PanelContext<'_>,
    typed: &mut TypedNumber,
    point: &InspectionPoint,
) -> Option<Option<ReadingLimits>> {
    widgets::section_head(ui, cx.tokens, texts::LIMITS_HEAD);
    let unit = point.limits.as_ref().map_or("", |limits| limits.unit.as_str());
    let units = units_of(point);
    let known = units.iter().find(|(known, _)| *known == unit).map(|(_, name)| *name);
    let shown = if point.limits.is_none() { texts::NOT_JUDGED } else { known.unwrap_or(unit) };
    let names = units.iter().map(|(_, name)| (*name).to_owned());
    let options: Vec<String> = std::iter::once(texts::NOT_JUDGED.to_owned()).chain(names).collect();
    if let Some(index) = select(ui, cx.tokens, texts::READING, texts::READING, shown, &options) {
        let limits = index.checked_sub(1).map(|index| {
            let unit = units[index].0.to_owned();
            // Numbers of another unit mean something else.
            let same = point.limits.clone().filter(|limits| limits.unit == unit);
            same.unwrap_or(ReadingLimits { min: None, max: None, unit })
        });
        return (limits != point.limits).then_some(limits);
    }
    let limits = point.limits.as_ref()?;
    let mut changed = limits.clone();
    // The smaller number stays below the greater one.
    let ranges = [
        [RANGE[0], limits.max.map_or(RANGE[1], |max| max - MIN_RANGE)],
        [limits.min.map_or(RANGE[0], |min| min + MIN_RANGE), RANGE[1]],
    ];
    for (index, value) in [limits.min, limits.max].into_iter().enumerate() {
        let name = texts::limit(index == 1, unit);
        let (object, range) = (ObjectId::InspectionPoint(point.id), ranges[index]);
        let field =
            NumberField { name: &name, object, value, hint: texts::NO_LIMIT, step: 1.0, decimals: 2, range };
        if let Some(value) = field.show(ui, cx, typed) {
            *[&mut changed.min, &mut changed.max][index] = value;
        }
    }
    widgets::remark(ui, cx.tokens, texts::LIMITS_REMARK);
    (changed != *limits).then_some(Some(changed))
}

/// Units of what a point reads, with their names: that of its gauge first.
fn units_of(point: &InspectionPoint) -> Vec<(&str, &str)> {
    let of_action = texts::units(&point.request.action);
    let gauge = point.gauge.as_ref().map(|dial| dial.unit.as_str());
    let is_new = |unit: &&str| of_action.iter().all(|(known, _)| known != unit);
    gauge.filter(is_new).map(|unit| (unit, unit)).into_iter().chain(of_action.iter().copied()).collect()
}
