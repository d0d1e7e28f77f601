//! The thread that has photos compared. New ones wait in the ledger: those after the last one that was compared, so that a restart loses none and compares none twice. Pairs that clients ask
//! for go first.

use super::photo::{PHOTO, Photo};
use super::texts;
use crate::clock::RobotClock;
use crate::ledger::{LedgerInbox, LedgerWork};
use crate::mailbox::Mailbox;
use crate::picture_queue::{PicturePair, PictureWork};
use crate::state_publisher::StatePublisher;
use api::{CoreMessage, Event, QueryReply, StoredResult};
use crossbeam_channel::{Receiver, TryRecvError, select};
use messages::Severity;
use ports::{ComparedPicture, PictureComparer};
use site_model::{PictureComparison, PictureComparisonOutcome};
use std::sync::Arc;
use std::time::Duration;
use store::Store;
use watchdog::{BEAT_PERIOD, Heartbeat};

/// Parameters of the comparisons of photos.
#[derive(Clone, Copy, Debug)]
struct PictureComparisonConfig {
    /// A comparison that takes longer hangs. Chosen: its process may take two minutes of processor time, with low priority.
    max_duration: Duration,
    /// Newest results among which the photos are compared when none was compared before, as after an update. Chosen: some days of missions, compared within an hour.
    max_backlog: u64,
}

const CONFIG: PictureComparisonConfig =
    PictureComparisonConfig { max_duration: Duration::from_secs(3_600), max_backlog: 2_000 };

/// The thread's end.
pub struct PictureWorker {
    pub comparer: Box<dyn PictureComparer>,
    pub store: Arc<Store>,
    pub ledger: Arc<LedgerInbox>,
    pub work: PictureWork,
    pub state_publisher: Arc<StatePublisher>,
    pub mailbox: Arc<Mailbox>,
    pub clock: Arc<RobotClock>,
    /// Disconnected when the core ends.
    pub stop: Receiver<()>,
}

/// A photo that is to be compared.
struct NewPhoto {
    result: StoredResult,
    photo: Photo,
    /// The photo before it at its point; none: it is the first one.
    before: Option<Photo>,
    /// Name of its point.
    point: String,
}

/// What comes after a result.
enum Next {
    /// Nothing to compare.
    None,
    /// A result without a photo, or whose photo was compared.
    Other(u64),
    New(Box<NewPhoto>),
}

impl PictureWorker {
    /// Works until the core ends.
    pub fn run(self, heartbeat: &Heartbeat) {
        // Number of the result up to which photos were compared; none: not known yet.
        let mut done = None;
        while !self.is_ending() {
            heartbeat.beat();
            // The other end lives as long as the ledger's queue, which this thread has too.
            select! {
                recv(self.work.pairs) -> pair => {
                    pair.into_iter().for_each(|pair| self.answer_pair(pair, heartbeat));
                }
                recv(self.work.wake) -> _ => self.compare_new(&mut done, heartbeat),
                default(BEAT_PERIOD) => {}
            }
        }
    }

    fn is_ending(&self) -> bool {
        matches!(self.stop.try_recv(), Err(TryRecvError::Disconnected))
    }

    /// Compares a pair that a client asks for.
    fn answer_pair(&self, pair: PicturePair, heartbeat: &Heartbeat) {
        let _job = heartbeat.begin_long_job(CONFIG.max_duration);
        let result = self.compare_pair(pair.results).map(QueryReply::PictureComparison);
        self.state_publisher.push(CoreMessage::Reply { number: pair.question, result });
    }

    /// Compares two photos, unless that was done. Returns the comparison as JSON, or none if they are not of one inspection point. Fails with a sentence.
    fn compare_pair(&self, [before, after]: [u64; 2]) -> Result<Option<String>, String> {
        let results = self.ledger.read(move |ledger, _| Ok([ledger.result(before)?, ledger.result(after)?]));
        let results = results.map_err(|reason| texts::not_read(&reason))?;
        let known = results[1].as_ref().and_then(|result| result.comparison.as_ref());
        if let Some(known) = known
            && serde_json::from_str(known).is_ok_and(|known: PictureComparison| known.before == before)
        {
            return Ok(Some(known.clone()));
        }
        let photos = results.each_ref().map(|result| result.as_ref().and_then(Photo::of));
        let [Some(photo_before), Some(photo_after)] = photos else {
            return Ok(None);
        };
        if photo_before.point != photo_after.point || before == after {
            return Ok(None);
        }
        let outcome = self.compare(&photo_before, &photo_after)?;
        json(&PictureComparison { before, outcome }).map(Some)
    }

    /// Compares all photos after the one that was compared last.
    fn compare_new(&self, done: &mut Option<u64>, heartbeat: &Heartbeat) {
        while !self.is_ending() {
            heartbeat.beat();
            // People wait for these.
            self.work.pairs.try_iter().for_each(|pair| self.answer_pair(pair, heartbeat));
            let _job = heartbeat.begin_long_job(CONFIG.max_duration);
            let compared = self.next_photo(*done).and_then(|(from, next)| {
                *done = Some(from);
                match next {
                    Next::None => Ok(false),
                    Next::Other(number) => {
                        *done = Some(number);
                        Ok(true)
                    }
                    Next::New(new) => {
                        let number = new.result.number;
                        let was_kept = self.compare_and_keep(*new)?;
                        if was_kept {
                            *done = Some(number);
                        }
                        Ok(was_kept)
                    }
                }
            });
            match compared {
                Ok(true) => {}
                Ok(false) => return,
                Err(reason) => return tracing::warn!("{}", texts::not_read(&reason)),
            }
        }
    }

    /// The next photo after a result, and that result, which is found in the ledger if it is not given. Fails with a clause.
    fn next_photo(&self, done: Option<u64>) -> Result<(u64, Next), String> {
        self.ledger.read(move |ledger, site| {
            let done = match done {
                // A damaged ledger may have been replaced by one that begins anew.
                Some(done) => done.min(ledger.newest_result()?),
                None => match ledger.last_compared_result()? {
                    Some(last) => last,
                    None => ledger.newest_result()?.saturating_sub(CONFIG.max_backlog),
                },
            };
            let Some(result) = ledger.next_point_result(PHOTO, done)? else {
                return Ok((done, Next::None));
            };
            let Some(photo) = Photo::of(&result).filter(|_| result.comparison.is_none()) else {
                return Ok((done, Next::Other(result.number)));
            };
            let before = ledger.earlier_point_result(photo.point, PHOTO, result.number)?;
            let before = before.as_ref().and_then(Photo::of);
            let point = site.inspection_point(photo.point);
            let point = point.map_or_else(|| texts::DELETED_POINT.to_owned(), |point| point.name.clone());
            Ok((done, Next::New(Box::new(NewPhoto { result, photo, before, point }))))
        })
    }

    /// Compares a photo with the one before, stores what was found and tells it. Returns false if the core ends, or the ledger cannot be written: it is compared
    /// again later. Fails with a clause.
    fn compare_and_keep(&self, new: NewPhoto) -> Result<bool, String> {
        let NewPhoto { mut result, photo, before, point } = new;
        let Some(before) = before else { return Ok(true) };
        let outcome = self.compare(&before, &photo);
        if self.is_ending() {
            return Ok(false);
        }
        let outcome = outcome.unwrap_or_else(PictureComparisonOutcome::NotAligned);
        let comparison = PictureComparison { before: before.result, outcome };
        let body = json(&comparison)?;
        let (done, written) = crossbeam_channel::bounded(1);
        let (number, kept) = (result.number, body.clone());
        self.ledger.write(LedgerWork {
            write: Box::new(move |writer, at| writer.put_picture_comparison(number, &kept, at)),
            done,
        })?;
        let written = written.recv().unwrap_or_else(|_| Err(crate::texts::CORE_ENDS.to_owned()));
        if let Err(reason) = written {
            self.mailbox.notice(self.clock.now(), Severity::Warning, texts::not_kept(&reason));
            return Ok(false);
        }
        result.comparison = Some(body);
        self.state_publisher.publish(Event::ResultStored(result));
        let changes = comparison.changes().len();
        if changes > 0 {
            self.mailbox.notice(self.clock.now(), Severity::Info, texts::changed(&point, changes));
        }
        Ok(true)
    }

    fn compare(&self, before: &Photo, after: &Photo) -> Result<PictureComparisonOutcome, String> {
        let dir = self.store.dir();
        let [before_file, after_file] = [before, after].map(|photo| dir.blob(photo.picture));
        self.comparer.compare(
            ComparedPicture { file: &before_file, report: &before.report },
            ComparedPicture { file: &after_file, report: &after.report },
            &mut || self.is_ending(),
        )
    }
}

/// As it is stored. Fails with a clause.
fn json(comparison: &PictureComparison) -> Result<String, String> {
    serde_json::to_string(comparison).map_err(|error| error.to_string())
}

#[cfg(test)]
#[path = "worker_tests.rs"]
mod tests;
