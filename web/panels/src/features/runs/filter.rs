//! Which of the runs that have ended are listed.

use super::texts;
use crate::TextInput;
use crate::feature_panel::PanelContext;
use crate::features::schedule::parse_date;
use crate::select::{select, show_caption};
use crate::widgets;
use client_model::{ClientCommand, RunQuery};
use egui::Ui;
use missions::{SiteZone, date_of, day_number};
use site_model::{LocalDate, LocalDateTime, LocalTime, MissionId, RunState, Site, Utc};

/// Longest text of a date, characters.
const MAX_DATE_CHARS: u32 = 10;

/// Which outcome is wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Outcome {
    #[default]
    All,
    Run(RunState),
    /// Slots of schedules that have no run.
    Skipped,
}

/// Which runs are listed.
#[derive(Debug, Default)]
pub(super) struct Filter {
    mission: Option<MissionId>,
    outcome: Outcome,
    /// As they are typed.
    from: String,
    to: String,
}

impl Filter {
    /// Whether runs are listed, or only slots that have none.
    pub(super) fn has_runs(&self) -> bool {
        self.outcome != Outcome::Skipped
    }

    /// Whether slots without a run are listed.
    pub(super) fn has_skipped(&self) -> bool {
        matches!(self.outcome, Outcome::All | Outcome::Skipped)
    }

    /// Whether it leaves anything out.
    pub(super) fn is_set(&self) -> bool {
        self.texts() != [""; 2] || self.mission.is_some() || self.outcome != Outcome::All
    }

    fn texts(&self) -> [&str; 2] {
        [&self.from, &self.to]
    }

    /// Whether a slot that was due then is listed.
    pub(super) fn has_slot(&self, query: &RunQuery, mission: Option<MissionId>, due: Utc) -> bool {
        self.has_skipped()
            && self.mission.is_none_or(|wanted| mission == Some(wanted))
            && query.from.is_none_or(|from| due >= from)
            && query.to.is_none_or(|to| due < to)
    }

    /// What is asked from the robot. A date that is not complete yet is left out.
    pub(super) fn query(&self, zone: &SiteZone) -> RunQuery {
        let midnight = |date: LocalDate, days: i64| {
            let date = date_of(day_number(date) + days);
            Some(zone.to_utc(LocalDateTime { date, time: LocalTime { hour: 0, minute: 0 } })?.0)
        };
        let outcome = match self.outcome {
            Outcome::Run(outcome) => Some(outcome),
            Outcome::All | Outcome::Skipped => None,
        };
        RunQuery {
            mission: self.mission,
            outcome,
            from: parse_date(&self.from).and_then(|date| midnight(date, 0)),
            // The last day is included.
            to: parse_date(&self.to).and_then(|date| midnight(date, 1)),
        }
    }

    /// Shows the fields, and asks for what they say.
    pub(super) fn show(&mut self, ui: &mut Ui, cx: &mut PanelContext<'_>, site: &Site, zone: &SiteZone) {
        let tokens = cx.tokens;
        ui.columns(2, |columns| {
            self.show_mission(&mut columns[0], cx, site);
            self.show_outcome(&mut columns[1], cx);
        });
        ui.columns(2, |columns| {
            let fields = [(texts::FROM_FILTER, &mut self.from), (texts::TO_FILTER, &mut self.to)];
            for (ui, (name, text)) in columns.iter_mut().zip(fields) {
                show_caption(ui, tokens, name);
                let field = TextInput::new(("runs", name), name).hint(texts::DATE_HINT);
                field.max_length(MAX_DATE_CHARS).show(ui, tokens, cx.text_inputs, text);
            }
        });
        let is_malformed = |text: &str| text.len() >= 8 && parse_date(text).is_none();
        if self.texts().into_iter().any(is_malformed) {
            widgets::remark(ui, tokens, texts::DATE_MALFORMED);
        }
        if self.is_set() {
            let clear = crate::button::Button::new(texts::CLEAR_FILTER).icon(crate::icon::X);
            if clear.wide(ui).show(ui, tokens).clicked() {
                *self = Self::default();
            }
        }
        let query = self.query(zone);
        if self.has_runs() && query != cx.model.runs.query() {
            cx.commands.push(ClientCommand::ListRuns(query));
        }
    }

    fn show_mission(&mut self, ui: &mut Ui, cx: &PanelContext<'_>, site: &Site) {
        let missions: Vec<_> = site.missions().collect();
        let mut options = vec![texts::ALL_MISSIONS.to_owned()];
        options.extend(missions.iter().map(|mission| mission.name.clone()));
        let chosen = missions.iter().position(|mission| Some(mission.id) == self.mission);
        let chosen = &options[chosen.map_or(0, |at| at + 1)];
        let name = texts::MISSION_FILTER;
        if let Some(picked) = select(ui, cx.tokens, name, name, chosen, &options) {
            self.mission = picked.checked_sub(1).and_then(|at| missions.get(at)).map(|mission| mission.id);
        }
    }

    fn show_outcome(&mut self, ui: &mut Ui, cx: &PanelContext<'_>) {
        let outcomes: Vec<Outcome> = [Outcome::All]
            .into_iter()
            .chain(texts::OUTCOMES.map(Outcome::Run))
            .chain([Outcome::Skipped])
            .collect();
        let name_of = |outcome: &Outcome| match outcome {
            Outcome::All => texts::ALL_OUTCOMES.to_owned(),
            Outcome::Run(state) => texts::run_state(*state).to_owned(),
            Outcome::Skipped => texts::SKIPPED.to_owned(),
        };
        let options: Vec<String> = outcomes.iter().map(name_of).collect();
        let name = texts::OUTCOME_FILTER;
        if let Some(picked) = select(ui, cx.tokens, name, name, &name_of(&self.outcome), &options) {
            self.outcome = outcomes[picked];
        }
    }
}
