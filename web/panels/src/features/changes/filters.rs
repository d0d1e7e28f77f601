//! Which changes are listed: a button that says what is chosen, and unfolds the choices below itself.

use super::texts;
use crate::button::Button;
use crate::feature_panel::PanelContext;
use crate::select::select;
use crate::widgets;
use egui::Ui;
use site_model::{ReviewState, SceneChange, SceneChangeKind, Utc, Zone, ZoneId};

/// Least longest sides of the filter by size, metres.
const MIN_SIZES_M: [f64; 3] = [0.0, 0.3, 1.0];
/// Place of the filter by state that shows acknowledged changes.
const ACKNOWLEDGED: usize = 1;
/// Greatest ages of the filter by age, seconds: any, a day, a week.
const MAX_AGES_S: [f64; 3] = [f64::INFINITY, 86_400.0, 7.0 * 86_400.0];

/// What is chosen, by its places in the texts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Chosen {
    review: usize,
    kind: usize,
    size: usize,
    age: usize,
    /// The zone in which a change is; none: the whole site.
    zone: Option<ZoneId>,
}

/// The filters of the list.
#[derive(Debug, Default)]
pub(super) struct Filters {
    chosen: Chosen,
    is_open: bool,
}

impl Filters {
    /// Shows the button, and the choices if they are unfolded. Returns what is listed now.
    pub(super) fn show<'a>(
        &mut self,
        ui: &mut Ui,
        cx: &PanelContext<'_>,
        zones: &[&'a Zone],
    ) -> ListedChanges<'a> {
        let tokens = cx.tokens;
        let listed = self.listed(zones, cx.clock.utc);
        let summary = texts::filters(&listed.names());
        let button = Button::new(texts::FILTERS).text(&summary).caret().on(self.is_open);
        if button.wide(ui).left().show(ui, tokens).clicked() {
            self.is_open = !self.is_open;
        }
        if self.is_open {
            self.show_choices(ui, cx, zones, listed.zone);
        }
        self.listed(zones, cx.clock.utc)
    }

    fn listed<'a>(&self, zones: &[&'a Zone], now: Utc) -> ListedChanges<'a> {
        let zone = zones.iter().copied().find(|zone| self.chosen.zone == Some(zone.id));
        ListedChanges { chosen: self.chosen, zone, now }
    }

    fn show_choices(&mut self, ui: &mut Ui, cx: &PanelContext<'_>, zones: &[&Zone], zone: Option<&Zone>) {
        let (tokens, chosen) = (cx.tokens, &mut self.chosen);
        for reviews in texts::REVIEWS {
            widgets::choice(ui, tokens, reviews, chosen.review, |on| chosen.review = on);
        }
        widgets::choice(ui, tokens, &texts::KINDS, chosen.kind, |on| chosen.kind = on);
        widgets::choice(ui, tokens, &texts::SIZES, chosen.size, |on| chosen.size = on);
        widgets::choice(ui, tokens, &texts::AGES, chosen.age, |on| chosen.age = on);
        if !zones.is_empty() {
            let names = zones.iter().map(|zone| zone.name.clone());
            let options: Vec<String> = std::iter::once(texts::WHOLE_SITE.to_owned()).chain(names).collect();
            let shown = zone.map_or(texts::WHOLE_SITE, |zone| &zone.name);
            if let Some(index) = select(ui, tokens, texts::ZONE, texts::ZONE, shown, &options) {
                // The first option is the whole site.
                chosen.zone = index.checked_sub(1).map(|index| zones[index].id);
            }
        }
        let is_default = *chosen == Chosen::default();
        let clear = Button::new(texts::CLEAR_FILTERS).enabled(!is_default).wide(ui);
        if clear.show(ui, tokens).clicked() {
            *chosen = Chosen::default();
        }
    }
}

/// Which changes are listed.
pub(super) struct ListedChanges<'a> {
    chosen: Chosen,
    zone: Option<&'a Zone>,
    now: Utc,
}

impl ListedChanges<'_> {
    /// Whether they are the acknowledged ones.
    pub(super) fn are_acknowledged(&self) -> bool {
        self.chosen.review == ACKNOWLEDGED
    }

    /// What is chosen, in words: the state, and whatever else leaves changes out.
    fn names(&self) -> Vec<&str> {
        let Chosen { review, kind, size, age, .. } = self.chosen;
        let mut names: Vec<&str> = Vec::new();
        let states = texts::REVIEWS.into_iter().flatten();
        names.extend(states.filter(|(_, value)| *value == review).map(|(name, _)| *name));
        for (choices, on) in [(&texts::KINDS[..], kind), (&texts::SIZES, size), (&texts::AGES, age)] {
            names.extend(choices.iter().filter(|(_, value)| on != 0 && *value == on).map(|(name, _)| *name));
        }
        names.extend(self.zone.map(|zone| zone.name.as_str()));
        names
    }

    /// Whether this one is among them.
    pub(super) fn admits(&self, change: &SceneChange) -> bool {
        let Chosen { review, kind, size, age, .. } = self.chosen;
        let own_kind = match change.kind {
            SceneChangeKind::Appeared => 1,
            SceneChangeKind::Removed => 2,
            SceneChangeKind::Moved { .. } => 3,
        };
        let is_of_state = match review {
            0 => change.review == ReviewState::New,
            ACKNOWLEDGED => change.review == ReviewState::Acknowledged,
            2 => change.review == ReviewState::Watched,
            3 => change.review == ReviewState::Routine,
            _ => true,
        };
        is_of_state
            && [0, own_kind].contains(&kind)
            && change.place.longest_side_m() >= MIN_SIZES_M[size]
            && age_s(change, self.now) <= MAX_AGES_S[age]
            && self.zone.is_none_or(|zone| zone.contains(change.place.centre_m))
    }
}

/// Seconds since a change was last seen.
pub(super) fn age_s(change: &SceneChange, now: Utc) -> f64 {
    (now.0 - change.last_seen.0) as f64 / 1e9
}
