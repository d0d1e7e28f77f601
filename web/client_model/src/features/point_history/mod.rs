//! The history of one inspection point: its results in all runs, what its readings have in common, and the two results that are compared.
//!
//! - `command`: what operators ask of it.
//! - `results`: results as they are kept, and their pages.
//! - `series`: readings over time, and the judgement of each result.
//! - `export`: all of it as a table.
//! - `alignment`: how the two photos that are compared are aligned.

mod alignment;
mod command;
mod export;
mod results;
mod series;

pub use alignment::PairAlignment;
pub use command::{HistorySpan, PointHistoryCommand};
pub use results::PointResult;
pub use series::{ReadingSeries, ResultJudgement, SeriesValue};

use super::Feature;
use super::site::SiteFeature;
use crate::shared::{Context, SliceChange};
use crate::{ClientCommand, ClientEffect, ClientEvent, StoredPage, StoredResult};
use alignment::AskedPairs;
use missions::SiteZone;
use results::PointResults;
use series::{SeriesBasis, analyse_results};
use site_model::{InspectionPoint, InspectionPointId, Utc};

/// The history that is open.
#[derive(Clone, Debug, Default)]
pub struct PointHistory {
    /// Counts how often a history was opened, so that views notice it.
    opened: u64,
    point: Option<InspectionPointId>,
    results: PointResults,
    problem: Option<String>,
    span: HistorySpan,
    chosen: Option<u64>,
    /// Whether the chosen result is older than those that were fetched.
    is_sought: bool,
    kept: Option<u64>,
    asked_pairs: AskedPairs,
    is_exporting: bool,
    /// What the series were computed for.
    basis: Option<SeriesBasis>,
    series: Vec<ReadingSeries>,
    /// Of each result that was analysed, by its number, in that order.
    judgements: Vec<(u64, ResultJudgement)>,
    /// The inspection point as the site has it.
    listed: Option<InspectionPoint>,
    zone: Option<(String, SiteZone)>,
}

impl PointHistory {
    /// The inspection point whose history is open.
    pub fn point(&self) -> Option<InspectionPointId> {
        self.point
    }

    /// The time zone of the site; none before a history is open.
    pub fn zone(&self) -> Option<&SiteZone> {
        self.zone.as_ref().map(|(_, zone)| zone)
    }

    /// How often a history was opened. Views that follow it go there when it has grown.
    pub fn opened(&self) -> u64 {
        self.opened
    }

    /// The results that were fetched, the oldest first.
    pub fn results(&self) -> &[PointResult] {
        self.results.items()
    }

    /// Grows with every computation of series and judgements.
    pub fn revision(&self) -> u64 {
        self.basis.as_ref().map_or(0, |basis| basis.revision)
    }

    /// Whether all results were fetched.
    pub fn is_whole(&self) -> bool {
        self.results.is_whole()
    }

    /// Whether results are fetched now.
    pub fn is_fetching(&self) -> bool {
        self.results.is_fetching()
    }

    /// Why results could not be fetched.
    pub fn problem(&self) -> Option<&str> {
        self.problem.as_deref()
    }

    /// The part that is shown.
    pub fn span(&self) -> HistorySpan {
        self.span
    }

    /// First and last instant of the part that is shown; none without results. They are an hour apart at least.
    pub fn range(&self) -> Option<[Utc; 2]> {
        const HOUR_NS: i64 = 3_600_000_000_000;
        let (oldest, newest) = (self.results().first()?.at, self.results().last()?.at);
        let [from, to] = match (self.span, self.span.length_ns()) {
            (HistorySpan::Between(between), _) => between,
            (_, Some(length_ns)) => [Utc(newest.0.saturating_sub(length_ns)), newest],
            (_, None) => [oldest, newest],
        };
        let missing_ns = HOUR_NS.saturating_sub(to.0.saturating_sub(from.0)).max(0);
        Some([Utc(from.0.saturating_sub(missing_ns / 2)), Utc(to.0.saturating_add(missing_ns / 2))])
    }

    /// The result that is chosen: the newest one until another is.
    pub fn later(&self) -> Option<&PointResult> {
        let chosen = self.chosen.and_then(|number| self.results.find(number));
        chosen.or_else(|| self.results().len().checked_sub(1)).map(|index| &self.results()[index])
    }

    /// The result with which it is compared: the one that is kept, or else the one before it that is of the same kind.
    pub fn earlier(&self) -> Option<&PointResult> {
        if let Some(index) = self.kept.and_then(|number| self.results.find(number)) {
            return Some(&self.results()[index]);
        }
        let later = self.later()?;
        let before = &self.results()[..self.results.find(later.number)?];
        before.iter().rev().find(|result| result.kind == later.kind)
    }

    /// How the photos of the two results that are compared are aligned.
    pub fn alignment(&self) -> PairAlignment<'_> {
        let (Some(earlier), Some(later)) = (self.earlier(), self.later()) else {
            return PairAlignment::NoPhotos;
        };
        if earlier.number == later.number || !earlier.has_photo() || !later.has_photo() {
            return PairAlignment::NoPhotos;
        }
        match &later.comparison {
            Some(stored) if stored.before == earlier.number => PairAlignment::Known(&stored.outcome),
            _ => self.asked_pairs.alignment((earlier.number, later.number)),
        }
    }

    /// Asks the robot for it, unless it is known.
    fn align(&mut self, cx: &mut Context<'_>) {
        let pair = self.earlier().zip(self.later()).map(|(earlier, later)| (earlier.number, later.number));
        let (PairAlignment::NotAsked | PairAlignment::Failed(_), Some(pair)) = (self.alignment(), pair)
        else {
            return;
        };
        if self.asked_pairs.ask(pair) {
            cx.effects.push(ClientEffect::ComparePictures { before: pair.0, after: pair.1 });
        }
    }

    /// The number of the result that is kept for the comparison.
    pub fn kept(&self) -> Option<u64> {
        self.kept.filter(|number| self.results.find(*number).is_some())
    }

    /// Whether there is a result this number of results later than the chosen one, or one might be fetched.
    pub fn can_step(&self, step: i64) -> bool {
        let Some(index) = self.later().and_then(|later| self.results.find(later.number)) else {
            return false;
        };
        let wanted = i64::try_from(index).ok().and_then(|index| index.checked_add(step));
        match wanted.map(usize::try_from) {
            Some(Ok(wanted)) => wanted < self.results().len(),
            _ => !self.is_whole(),
        }
    }

    /// Readings over time: those of the newest result first, in its order.
    pub fn series(&self) -> &[ReadingSeries] {
        &self.series
    }

    /// How a result is judged, by its number. One that was just fetched may not be judged yet.
    pub fn judgement(&self, number: u64) -> ResultJudgement {
        let found = self.judgements.binary_search_by_key(&number, |(of, _)| *of);
        found.map_or(ResultJudgement::NotJudged, |index| self.judgements[index].1)
    }

    /// The results with their judgements, the oldest first. Linear in their number.
    pub fn judged(&self) -> impl Iterator<Item = (&PointResult, ResultJudgement)> {
        // Both lists are in the order of the numbers.
        let mut judgements = self.judgements.iter().peekable();
        self.results().iter().map(move |result| {
            while judgements.next_if(|(number, _)| *number < result.number).is_some() {}
            let judged = judgements.peek().filter(|(number, _)| *number == result.number);
            (result, judged.map_or(ResultJudgement::NotJudged, |(_, judgement)| *judgement))
        })
    }

    /// The place of a result in the list of all, by its number.
    pub fn place_of(&self, number: u64) -> Option<usize> {
        self.results.find(number)
    }

    /// Whether older results are fetched to save all of them.
    pub fn is_exporting(&self) -> bool {
        self.is_exporting
    }

    /// Follows the site: the name and the limits of the point, and the time zone.
    pub(crate) fn update(&mut self, site: &SiteFeature) {
        let Some(point) = self.point else { return };
        let site = site.site();
        let listed = site.and_then(|site| site.inspection_point(point));
        if self.listed.as_ref() != listed {
            self.listed = listed.cloned();
        }
        let name = site.and_then(|site| site.settings()).map_or("UTC", |settings| &settings.time_zone);
        if self.zone.as_ref().is_none_or(|(known, _)| known != name) {
            let zone = SiteZone::new(name).unwrap_or_else(|_| SiteZone::utc());
            self.zone = Some((name.to_owned(), zone));
        }
        self.analyse();
    }

    /// Computes series and judgements if results, limits or time zone have changed. While pages come one after the other that waits until the results
    /// are twice as many, so that all pages together cost about as much as twice the last computation.
    fn analyse(&mut self) {
        let Some((zone_name, zone)) = &self.zone else { return };
        let limits = self.listed.as_ref().and_then(|point| point.limits.clone());
        let (count, is_fetching) = (self.results().len(), self.results.is_fetching());
        let is_recent = |basis: &SeriesBasis| {
            let is_same = basis.results == self.results.revision();
            let has_few_more = is_fetching && basis.count <= count && count < 2 * basis.count;
            basis.limits == limits && basis.zone == *zone_name && (is_same || has_few_more)
        };
        if self.basis.as_ref().is_some_and(is_recent) {
            return;
        }
        (self.series, self.judgements) = analyse_results(self.results.items(), limits.as_ref(), zone);
        let (results, zone, revision) = (self.results.revision(), zone_name.clone(), self.revision() + 1);
        self.basis = Some(SeriesBasis { results, count, limits, zone, revision });
    }

    fn open(&mut self, point: InspectionPointId, cx: &mut Context<'_>) {
        self.opened += 1;
        if self.point != Some(point) {
            let (opened, span) = (self.opened, self.span);
            let basis = self.basis.take().map(|basis| SeriesBasis { zone: String::new(), ..basis });
            // A stretch between two instants belongs to the point that was open.
            let span = if matches!(span, HistorySpan::Between(_)) { HistorySpan::default() } else { span };
            *self = Self { opened, span, basis, point: Some(point), ..Self::default() };
        }
        if self.results().is_empty() || self.problem.is_some() {
            self.fetch_newest(cx);
        }
    }

    fn fetch_newest(&mut self, cx: &mut Context<'_>) {
        self.problem = None;
        if let Some(point) = self.point {
            self.results.begin_newest();
            cx.effects.push(ClientEffect::FetchPointResults { point, before: None });
        }
    }

    /// Fetches the next page of older results, if there is one and none is on its way.
    fn fetch_older(&mut self, cx: &mut Context<'_>) {
        if let (Some(point), Some(before)) = (self.point, self.results.begin_older()) {
            self.problem = None;
            cx.effects.push(ClientEffect::FetchPointResults { point, before: Some(before) });
        }
    }

    /// Fetches older results while what is shown, or is to be saved, needs them.
    fn follow(&mut self, cx: &mut Context<'_>) {
        if self.problem.is_some() {
            return;
        }
        let oldest = self.results().first().map(|result| result.at);
        let is_covered = match (self.span, self.range()) {
            (HistorySpan::All, _) => false,
            (_, Some([from, _])) => oldest.is_some_and(|oldest| oldest < from),
            (_, None) => true,
        };
        if self.is_exporting || self.is_sought || !is_covered {
            self.fetch_older(cx);
        }
        if self.is_exporting && self.is_whole() {
            self.is_exporting = false;
            self.save(cx);
        }
    }

    /// Chooses a result. One that was not fetched yet is sought among the older ones.
    fn choose(&mut self, number: u64, cx: &mut Context<'_>) {
        self.chosen = Some(number);
        self.seek();
        self.follow(cx);
    }

    /// Looks for the chosen result. Once it is there, the part that is shown moves to it.
    fn seek(&mut self) {
        let found = self.chosen.and_then(|number| self.results.find(number));
        self.is_sought = found.is_none() && !self.is_whole();
        let (Some(index), Some([from, to])) = (found, self.range()) else { return };
        let at = self.results()[index].at;
        if !(from..=to).contains(&at) {
            let half_ns = (to.0 - from.0) / 2;
            let between = [at.0.saturating_sub(half_ns), at.0.saturating_add(half_ns)];
            self.span = HistorySpan::Between(between.map(Utc));
        }
    }

    /// Saves all results as a table.
    fn save(&mut self, cx: &mut Context<'_>) {
        let Some(point) = self.point else { return };
        self.analyse();
        let name = self.listed.as_ref().map_or_else(|| point.to_string(), |point| point.name.clone());
        let utc = ("UTC".to_owned(), SiteZone::utc());
        let zone = self.zone.as_ref().unwrap_or(&utc);
        let text = export::table(self.results(), &self.series, zone);
        cx.effects.push(ClientEffect::SaveTable { name: export::file_name(&name), text });
    }

    fn step(&mut self, step: i64, cx: &mut Context<'_>) {
        let Some(index) = self.later().and_then(|later| self.results.find(later.number)) else { return };
        let wanted = i64::try_from(index).ok().and_then(|index| usize::try_from(index + step).ok());
        match wanted.and_then(|wanted| self.results().get(wanted)) {
            Some(result) => self.choose(result.number, cx),
            None if step < 0 => self.fetch_older(cx),
            None => {}
        }
    }

    fn on_page(
        &mut self,
        before: Option<&str>,
        result: &Result<StoredPage<StoredResult>, String>,
        cx: &mut Context<'_>,
    ) {
        if !self.results.is_awaited(before) {
            return;
        }
        match result {
            Ok(page) => {
                self.results.add(before, page);
                if self.is_sought {
                    self.seek();
                }
            }
            Err(sentence) => {
                self.results.give_up();
                (self.is_exporting, self.is_sought) = (false, false);
                self.problem = Some(sentence.clone());
            }
        }
        self.follow(cx);
    }
}

impl Feature for PointHistory {
    fn on_event(&mut self, event: &api::Event, _cx: &mut Context<'_>) {
        if let (api::Event::ResultStored(stored), Some(point)) = (event, self.point) {
            self.results.add_stored(stored, point);
        }
    }

    fn on_client_event(&mut self, event: &ClientEvent, cx: &mut Context<'_>) {
        match event {
            ClientEvent::PointResultsFetched { point, before, result } if self.point == Some(*point) => {
                self.on_page(before.as_deref(), result, cx);
            }
            ClientEvent::PicturesCompared { before, after, result } => {
                self.asked_pairs.answer((*before, *after), result.clone());
            }
            _ => {}
        }
    }

    fn on_command(&mut self, command: &ClientCommand, cx: &mut Context<'_>) {
        let ClientCommand::PointHistory(command) = command else { return };
        match *command {
            PointHistoryCommand::Open(point) => self.open(point, cx),
            PointHistoryCommand::ShowSpan(span) => {
                self.span = span;
                self.follow(cx);
            }
            PointHistoryCommand::Choose(number) => self.choose(number, cx),
            PointHistoryCommand::Step(step) => self.step(step, cx),
            PointHistoryCommand::Keep(number) => self.kept = number,
            PointHistoryCommand::Align => self.align(cx),
            PointHistoryCommand::Retry if self.results().is_empty() => self.fetch_newest(cx),
            PointHistoryCommand::Retry => self.fetch_older(cx),
            PointHistoryCommand::Export => {
                self.is_exporting = !self.results().is_empty();
                self.problem = None;
                self.follow(cx);
            }
            PointHistoryCommand::CancelExport => self.is_exporting = false,
        }
    }

    fn on_change(&mut self, change: &SliceChange, cx: &mut Context<'_>) {
        // Results that were stored meanwhile are missing. Those that are known stay until the newest page is there.
        if *change == SliceChange::Connected {
            self.asked_pairs.give_up();
            self.fetch_newest(cx);
        }
    }
}

#[cfg(test)]
mod tests;
