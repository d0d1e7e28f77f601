//! Records inputs on a thread of its own, in segments.
//!
//! The queue holds about ten seconds of inputs of a fully equipped robot. When it is full or the disk fails, recording pauses, and begins again by itself
//! with a new segment once that is possible; the number of missing inputs is told then. The robot goes on meanwhile. Segments around incidents are pinned, so that they
//! outlive others.

use crate::clock::RobotClock;
use crate::incidents::{Incident, IncidentDetector};
use crate::mailbox::Mailbox;
use crate::texts;
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, TrySendError};
use messages::{Input, Publication, Severity};
use ports::{Journal, Segment, SegmentWriter, error_with_causes};
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};
use store::{RecordedRun, RecordingSpace};
use vocab::{Span, Stamp};
use watchdog::{BEAT_PERIOD, Heartbeat};

/// Parameters of the [`Recorder`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecorderConfig {
    /// Inputs that may wait for the disk: ten seconds at 600 inputs a second. Chosen: disks that stall do so for some seconds; with full sweeps it is 140 MB.
    pub max_queued_inputs: usize,
    /// Incidents that may wait. Further ones are close to these and need no pins of their own. Chosen: an incident pins four minutes.
    pub max_queued_incidents: usize,
    /// Time between two checks for incidents and for space on the disk. Chosen: some 4 MB are written meanwhile.
    pub maintenance_period: Duration,
    /// Longest time of a segment. Chosen: 5 minutes; shorter segments pin less for an incident, longer ones are fewer files.
    pub segment_duration: Span,
    /// Time before and after an incident whose segments are pinned. Chosen: what led to an incident is seen in two minutes.
    pub incident_margin: Span,
}

impl Default for RecorderConfig {
    fn default() -> Self {
        Self {
            max_queued_inputs: 6_000,
            max_queued_incidents: 64,
            maintenance_period: Duration::from_secs(5),
            segment_duration: Span::from_millis(300_000),
            incident_margin: Span::from_millis(120_000),
        }
    }
}

/// Where a run is recorded.
pub struct RecordingTarget {
    /// Creates the files.
    pub writer: Box<dyn SegmentWriter>,
    /// Their places.
    pub run: RecordedRun,
}

/// An input with its number, by which the recorder notices missing ones.
type NumberedInput = (u64, Stamp, Input);

/// The control loop's end of the recorder.
pub struct RecorderQueue {
    channels: Option<(Sender<NumberedInput>, Sender<Incident>)>,
    next_number: u64,
    incidents: IncidentDetector,
}

impl RecorderQueue {
    /// Records nothing.
    pub fn none() -> Self {
        Self { channels: None, next_number: 0, incidents: IncidentDetector::default() }
    }

    /// Queues one input. Never blocks: an input that finds the queue full is left out.
    pub fn record(&mut self, at: Stamp, input: &Input) {
        if let Some(incident) = self.incidents.of_input(at, input) {
            self.report(incident);
        }
        let Some((inputs, _)) = &self.channels else {
            return;
        };
        let number = self.next_number;
        self.next_number += 1;
        // The recorder notices the gap in the numbers, or has ended.
        let _ = inputs.try_send((number, at, input.clone()));
    }

    /// Looks for an incident in what the stack publishes.
    pub fn watch(&mut self, at: Stamp, publication: &Publication) {
        if let Some(incident) = self.incidents.of_publication(at, publication) {
            self.report(incident);
        }
    }

    /// Queues an incident. Never blocks.
    pub fn report(&self, incident: Incident) {
        if let Some((_, incidents)) = &self.channels
            && let Err(TrySendError::Full(incident)) = incidents.try_send(incident)
        {
            tracing::warn!("too many incidents wait to be recorded: {}", incident.text);
        }
    }
}

/// What becomes of inputs.
enum State {
    /// They go into this segment.
    Recording(OpenSegment),
    /// The next one begins a segment.
    Ready {
        /// Whether it is the continuation of the segment before.
        continues: bool,
    },
    /// They are left out until there is room.
    Paused {
        /// Room in the queue, which the disk was too slow to empty; else room on the disk.
        in_queue: bool,
    },
}

/// The running segment.
struct OpenSegment {
    journal: Box<dyn Journal>,
    span: SegmentSpan,
}

/// When a segment was recorded.
#[derive(Clone, Copy, Debug)]
struct SegmentSpan {
    number: u32,
    begins: Stamp,
    ends: Stamp,
    is_pinned: bool,
}

/// The recorder's end of the queue.
pub struct Recorder {
    config: RecorderConfig,
    writer: Box<dyn SegmentWriter>,
    run: RecordedRun,
    inputs: Receiver<NumberedInput>,
    incidents: Receiver<Incident>,
    mailbox: Arc<Mailbox>,
    clock: Arc<RobotClock>,
    state: State,
    /// Number of the next input.
    next_input: u64,
    /// Number of the next segment.
    next_segment: u32,
    /// Inputs that are missing since recording paused.
    missing: Option<u64>,
    /// Segments that a later incident may pin.
    recent: VecDeque<SegmentSpan>,
    /// Until when segments are pinned, and why.
    pinned_until: Option<(Stamp, String)>,
}

impl Recorder {
    /// Both ends of the queue.
    pub fn new(
        config: RecorderConfig,
        target: RecordingTarget,
        mailbox: Arc<Mailbox>,
        clock: Arc<RobotClock>,
    ) -> (RecorderQueue, Self) {
        let (input_sender, inputs) = crossbeam_channel::bounded(config.max_queued_inputs);
        let (incident_sender, incidents) = crossbeam_channel::bounded(config.max_queued_incidents);
        let queue = RecorderQueue {
            channels: Some((input_sender, incident_sender)),
            next_number: 0,
            incidents: IncidentDetector::default(),
        };
        let recorder = Self {
            config,
            writer: target.writer,
            run: target.run,
            inputs,
            incidents,
            mailbox,
            clock,
            state: State::Ready { continues: true },
            next_input: 0,
            next_segment: 0,
            missing: None,
            recent: VecDeque::new(),
            pinned_until: None,
        };
        (queue, recorder)
    }

    /// Writes until the control loop ends, then closes the file.
    pub fn run(mut self, heartbeat: &Heartbeat) {
        let mut maintenance_at = Instant::now();
        loop {
            heartbeat.beat();
            match self.inputs.recv_deadline(maintenance_at.min(Instant::now() + BEAT_PERIOD)) {
                Ok(input) => self.record(input),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if Instant::now() >= maintenance_at {
                self.maintain();
                maintenance_at = Instant::now() + self.config.maintenance_period;
            }
        }
        self.finish();
    }

    /// Records one input, in a new segment if one is due.
    fn record(&mut self, (number, at, input): NumberedInput) {
        let left_out = number - std::mem::replace(&mut self.next_input, number + 1);
        if left_out > 0 {
            *self.missing.get_or_insert(0) += left_out;
            self.close(State::Paused { in_queue: true });
        }
        let is_drained = self.inputs.len() <= self.config.max_queued_inputs / 2;
        if is_drained && matches!(self.state, State::Paused { in_queue: true }) {
            self.state = State::Ready { continues: false };
        }
        if self.is_segment_due(at) {
            self.close(State::Ready { continues: true });
        }
        if let State::Ready { continues } = self.state {
            self.open(at, continues);
        }
        let State::Recording(segment) = &mut self.state else {
            *self.missing.get_or_insert(0) += 1;
            return;
        };
        segment.span.ends = at;
        if let Err(error) = segment.journal.append(at, &input) {
            self.pause(&error_with_causes(&error));
            *self.missing.get_or_insert(0) += 1;
        } else if let Some(missing) = self.missing.take() {
            self.publish_notice(Severity::Warning, texts::recording_resumed(missing));
        }
    }

    /// Whether the running segment is to end before an input at `at`: it is long, or pinned for an incident that is long past.
    fn is_segment_due(&self, at: Stamp) -> bool {
        let State::Recording(OpenSegment { span, .. }) = &self.state else { return false };
        let pin_ends = self.pinned_until.as_ref().is_some_and(|(until, _)| at > *until);
        at - span.begins >= self.config.segment_duration || span.is_pinned && pin_ends
    }

    /// Begins a segment with an input at `at`.
    fn open(&mut self, at: Stamp, continues: bool) {
        let number = self.next_segment;
        let segment = Segment { run: self.run.name().to_owned(), number, continues };
        match self.writer.create(&self.run.segment(number), &segment) {
            Ok(journal) => {
                self.next_segment += 1;
                let span = SegmentSpan { number, begins: at, ends: at, is_pinned: false };
                self.state = State::Recording(OpenSegment { journal, span });
            }
            Err(error) => return self.pause(&error_with_causes(&error)),
        }
        if number == 0 && self.run.follows_interruption() {
            self.pin_around(&Incident { at, text: texts::RESTARTED.to_owned() });
        } else if let Some((_, reason)) = self.pinned_until.clone().filter(|(until, _)| at <= *until) {
            self.pin_running(&reason);
        }
    }

    /// Ends the running segment, if there is one.
    fn close(&mut self, next: State) {
        if let State::Recording(OpenSegment { journal, span }) = std::mem::replace(&mut self.state, next) {
            self.recent.push_back(span);
            let outdated = span.ends - self.config.incident_margin - self.config.incident_margin;
            while self.recent.front().is_some_and(|oldest| oldest.ends < outdated) {
                self.recent.pop_front();
            }
            if let Err(error) = journal.finish() {
                // What was flushed before can be read.
                self.pause(&error_with_causes(&error));
            }
        }
    }

    /// Stops recording until there is room on the disk. The reason is told unless inputs are missing already.
    fn pause(&mut self, reason: &str) {
        if self.missing.is_none() {
            self.missing = Some(0);
            self.publish_notice(Severity::Error, texts::recording_paused(reason));
        }
        self.close(State::Paused { in_queue: false });
    }

    /// Pins segments around incidents, and makes room.
    fn maintain(&mut self) {
        while let Ok(incident) = self.incidents.try_recv() {
            self.pin_around(&incident);
        }
        let running = match &self.state {
            State::Recording(segment) => Some(segment.span.number),
            State::Ready { .. } | State::Paused { .. } => None,
        };
        if let Some(number) = running
            && self.run.is_full(number).unwrap_or(false)
        {
            self.close(State::Ready { continues: true });
        }
        match (self.run.make_room(running), &self.state) {
            (Ok(RecordingSpace::Available), State::Paused { .. }) => {
                self.state = State::Ready { continues: false }
            }
            (Ok(RecordingSpace::Available), _) | (_, State::Paused { .. }) => {}
            (Ok(RecordingSpace::Exhausted), _) => {
                self.pause(texts::RECORDINGS_FILL_THEIR_SHARE);
            }
            (Err(error), _) => self.pause(&error_with_causes(&error)),
        }
    }

    /// Ends the recording of the run.
    fn finish(&mut self) {
        while let Ok(incident) = self.incidents.try_recv() {
            self.pin_around(&incident);
        }
        self.close(State::Paused { in_queue: false });
        if let Some(missing) = self.missing.filter(|missing| *missing > 0) {
            tracing::warn!("{}", texts::recording_ended_early(missing));
        }
        if let Err(error) = self.run.end() {
            tracing::error!("{}", error_with_causes(&error));
        }
    }

    /// Pins the segments around an incident, also those that begin later.
    fn pin_around(&mut self, incident: &Incident) {
        let margin = self.config.incident_margin;
        let (from, until) = (incident.at - margin, incident.at + margin);
        let recent = self.recent.iter_mut().filter(|span| span.ends >= from && span.begins <= until);
        for span in recent {
            span.is_pinned = true;
            pin(&self.run, span.number, &incident.text);
        }
        self.pin_running(&incident.text);
        let is_later = self.pinned_until.as_ref().is_none_or(|(pinned, _)| *pinned < until);
        if is_later {
            self.pinned_until = Some((until, incident.text.clone()));
        }
    }

    fn pin_running(&mut self, reason: &str) {
        if let State::Recording(segment) = &mut self.state {
            segment.span.is_pinned = true;
            pin(&self.run, segment.span.number, reason);
        }
    }

    fn publish_notice(&self, severity: Severity, text: String) {
        tracing::warn!("{text}");
        self.mailbox.notice(self.clock.now(), severity, text);
    }
}

/// Pins a segment; recording goes on if the disk fails.
fn pin(run: &RecordedRun, number: u32, reason: &str) {
    if let Err(error) = run.pin(number, reason) {
        tracing::error!("{}", error_with_causes(&error));
    }
}

#[cfg(test)]
#[path = "recording_tests.rs"]
mod tests;
