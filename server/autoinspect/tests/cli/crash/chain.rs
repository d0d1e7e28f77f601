//! Kills one after the other on the same data directory, with the checks after each start. What one case leaves, the next one finds.

use super::case::{CrashSituation, Killed, map_until};
use super::inventory::{
    Inventory, check_whole, copy_folder, files_of_maps, first_change, inventory, make_old, temporary_files,
};
use super::options::CrashOptions;
use super::report::{CaseReport, CrashReport};
use super::target::{START_LIMIT, Target, Victim, processes_of};
use crate::fake_gateway::{CLIENT, until};
use crate::import::room_with_table_at;
use api::{Command, Import, InterruptedSession, MapSummary, Motion};
use geometry::{Rng, RngTree};
use std::collections::BTreeMap;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use uuid::Uuid;
use vocab::{MapId, SessionId, UploadId};

/// Interrupted sessions that are left undecided at most, so that a start reads no more of them than a platform has.
const MAX_UNDECIDED_SESSIONS: usize = 3;

/// Keyframes that a session may make in the second that a kill may lose: their clouds may be missing.
const KEYFRAMES_OF_A_SECOND: usize = 1;

/// Longest time of a recording that a kill may lose, seconds of the robot's clock: the second after which it is flushed, and 0.1 s of this computer for the
/// recorder's queue, as the simulation runs four times as fast.
const RECORDING_LOSS_LIMIT_S: f64 = 1.4;

/// What has to be there after each start.
#[derive(Default)]
pub struct Expected {
    /// Saved maps, with the number of their keyframes.
    pub maps: BTreeMap<MapId, u32>,
    /// Maps that were listed since the last check.
    pub maps_certain: Vec<MapId>,
    /// Interrupted sessions that nobody has decided on, with their keyframes.
    pub sessions: BTreeMap<SessionId, u32>,
    pub is_stopped: bool,
    /// Hashes of the files of all saved maps.
    files: Inventory,
}

/// Time of each step without a kill, on this computer.
#[derive(Clone, Copy, Debug, Default)]
pub struct Times {
    pub start: Duration,
    pub finish: Duration,
    pub save_interrupted: Duration,
    pub import: Duration,
}

/// A data directory, and what has to be in it.
pub struct Chain {
    pub situation: CrashSituation,
    pub victim: Victim,
    /// Folder of the data directory and of the log.
    pub dir: PathBuf,
    pub expected: Expected,
    pub times: Times,
    /// Keyframes of the interrupted session that is copied. The clouds in its folder may be one more: a kill can come between a cloud and its entry in the journal.
    template_keyframes: u32,
    /// Numbers of ids.
    made: u128,
    seed: u64,
}

/// Runs the kills of one situation, and fails if anything was lost.
pub fn kill_repeatedly(situation: CrashSituation) {
    let options = CrashOptions::from_environment();
    let mut report = CrashReport::new(&options, situation.name());
    let seeds = RngTree::new(options.seed).child(situation.name());
    let mut running: Option<(Chain, Target)> = None;
    for case in options.cases() {
        let mut rng = seeds.child(&case.to_string()).rng();
        let mut row = CaseReport { case, what: "setup".to_owned(), ..CaseReport::default() };
        let before = running.take();
        let result = catch_unwind(AssertUnwindSafe(|| {
            let (mut chain, target) = match before {
                Some(before) => before,
                None => Chain::set_up(situation, case, &options)?,
            };
            let target = chain.run_case(target, &mut rng, &mut row)?;
            Ok((chain, target))
        }));
        match result {
            Ok(Ok(next)) => running = Some(next),
            Ok(Err(failure)) => row.failure = Some(failure),
            Err(panic) => {
                let said = panic.downcast_ref::<String>().cloned();
                let said = said.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()));
                row.failure = Some(said.unwrap_or_else(|| "a check panicked".to_owned()));
            }
        }
        report.add(&row);
    }
    if let Some((chain, target)) = running {
        let mut row =
            CaseReport { case: options.kills, what: "leftovers".to_owned(), ..CaseReport::default() };
        row.failure = chain.check_leftovers(target).err();
        if row.failure.is_some() {
            report.add(&row);
        }
    }
    report.finish();
}

impl Chain {
    /// Makes a data directory with one saved map, and measures how long each step takes.
    fn set_up(
        situation: CrashSituation,
        case: usize,
        options: &CrashOptions,
    ) -> Result<(Self, Target), String> {
        let dir = tempfile::Builder::new().prefix("crash-").tempdir().expect("temporary directory");
        // The folder stays where a case fails, to be looked into.
        let dir = dir.keep();
        let first = Target::start(Victim::Core, &dir)?;
        let mut chain = Self {
            situation,
            victim: Victim::Core,
            dir,
            expected: Expected::default(),
            times: Times { start: first.start, ..Times::default() },
            template_keyframes: 0,
            made: (case as u128) << 32,
            seed: options.seed,
        };
        let mut target = first;
        let (session, map) = (chain.new_session(), chain.new_map());
        map_until(&mut target.client, session, 3)?;
        let start = Instant::now();
        target.client.command(Command::FinishMapping { map, name: "Hall".to_owned() })?;
        target.client.until("the map is listed", |state| state.maps.iter().flatten().any(|m| m.id == map))?;
        chain.times.finish = start.elapsed();
        target.client.until("mapping has ended", |state| state.mapping == api::Mapping::Idle)?;
        let keyframes = target.client.state.maps.iter().flatten().find(|m| m.id == map).map(|m| m.keyframes);
        chain.expected.maps.insert(map, keyframes.unwrap_or_default());
        match situation {
            CrashSituation::Saving => target = chain.make_template_session(target)?,
            CrashSituation::Importing => {
                let (upload, name) = chain.upload_room();
                let start = Instant::now();
                target.client.command(Command::ImportMap { upload, name, frame: None })?;
                target.client.until("an import", |state| matches!(state.import, Import::Done { .. }))?;
                chain.times.import = start.elapsed();
                let Import::Done { map, .. } = target.client.state.import else { unreachable!() };
                target.client.until("it is listed", |s| s.maps.iter().flatten().any(|m| m.id == map))?;
                let maps = target.client.state.maps.iter().flatten();
                chain.expected.maps.extend(maps.map(|map| (map.id, map.keyframes)));
            }
            CrashSituation::Mapping | CrashSituation::Localising | CrashSituation::Idle => {}
        }
        let all = inventory(&chain.data());
        chain.expected.files = files_of_maps(&all, &chain.data(), chain.expected.maps.keys().copied());
        Ok((chain, target))
    }

    /// Leaves an interrupted session to be copied, and measures how long saving it takes.
    fn make_template_session(&mut self, mut target: Target) -> Result<Target, String> {
        let (session, map) = (self.new_session(), self.new_map());
        map_until(&mut target.client, session, 3)?;
        let folder = self.data().join("sessions").join(session.to_string());
        drop(target.kill());
        copy_folder(&folder, &self.dir.join("template"));
        let mut target = Target::start(Victim::Core, &self.dir)?;
        let start = Instant::now();
        let name = "Hall".to_owned();
        target.client.command(Command::SaveInterruptedSession { session, map, name, resume_as: None })?;
        self.times.save_interrupted = start.elapsed();
        let is_saved = |maps: &Vec<MapSummary>| maps.iter().any(|listed| listed.id == map);
        target.client.until("it is listed", |state| state.maps.as_ref().is_some_and(is_saved))?;
        drop(target.kill());
        let copy = self.place_template_session();
        let target = self.start(Victim::Core)?;
        let maps = target.client.state.maps.iter().flatten();
        self.expected.maps.extend(maps.map(|map| (map.id, map.keyframes)));
        let sessions = target.client.state.sessions.iter().flatten();
        self.expected.sessions.extend(sessions.map(|session| (session.session, session.keyframes)));
        self.template_keyframes =
            *self.expected.sessions.get(&copy).ok_or("the copied session is not listed")?;
        Ok(target)
    }

    /// Copies the interrupted session, as if one more had been interrupted.
    fn place_template_session(&mut self) -> SessionId {
        let session = self.new_session();
        copy_folder(&self.dir.join("template"), &self.data().join("sessions").join(session.to_string()));
        session
    }

    pub fn data(&self) -> PathBuf {
        self.dir.join("data")
    }

    fn next_id(&mut self) -> Uuid {
        self.made += 1;
        Uuid::from_u128((u128::from(self.seed) << 64) | self.made)
    }

    pub fn new_session(&mut self) -> SessionId {
        SessionId(self.next_id())
    }

    pub fn new_map(&mut self) -> MapId {
        MapId(self.next_id())
    }

    /// The map that the chain begins with.
    pub fn first_map(&self) -> MapId {
        *self.expected.maps.keys().next().expect("the chain begins with a map")
    }

    /// Puts a file where the gateway puts uploads. Returns its id and the name for its map.
    pub fn upload_room(&mut self) -> (UploadId, String) {
        let id = UploadId(self.next_id());
        let table_x = 0.5 + 5.0 * ((self.made % 997) as f64 / 997.0);
        let uploads = self.data().join("uploads");
        fs::create_dir_all(&uploads).expect("made");
        fs::write(uploads.join(id.to_string()), room_with_table_at(table_x)).expect("written");
        (id, format!("Room {}", self.made))
    }

    /// Starts the program and waits until its first state is complete.
    fn start(&self, victim: Victim) -> Result<Target, String> {
        let mut target = Target::start(victim, &self.dir)?;
        target.client.until("the first state", |state| {
            state.maps.is_some()
                && state.sessions.is_some()
                && state.damaged_maps.is_some()
                && state.motion.is_some()
        })?;
        Ok(target)
    }

    /// One kill, the next start, and all checks.
    fn run_case(&mut self, target: Target, rng: &mut Rng, row: &mut CaseReport) -> Result<Target, String> {
        row.what = self.victim.name().to_owned();
        let (killed, running) = self.kill(target, rng)?;
        row.what.clone_from(&killed.what);
        let mut target = match running {
            Some(running) => running,
            None => {
                if self.situation == CrashSituation::Saving && self.expected.sessions.is_empty() {
                    let session = self.place_template_session();
                    self.expected.sessions.insert(session, self.template_keyframes);
                }
                self.victim = Victim::draw(rng);
                let target = self.start(self.victim)?;
                row.start = Some(target.start);
                target
            }
        };
        self.check(&mut target, &killed, row)?;
        self.decide(&mut target, rng)?;
        Ok(target)
    }

    /// Checks that nothing was lost and nothing is there twice. Afterwards what is there is expected.
    fn check(&mut self, target: &mut Target, killed: &Killed, row: &mut CaseReport) -> Result<(), String> {
        if let Some(start) = row.start.filter(|start| *start > START_LIMIT) {
            return Err(format!("the start took {:.1} s", start.as_secs_f64()));
        }
        let state = target.client.state.clone();
        let maps = state.maps.as_deref().unwrap_or_default();
        let sessions = state.sessions.as_deref().unwrap_or_default();
        check_listed_once(maps, sessions)?;
        let damaged = state.damaged_maps.unwrap_or_default();
        if !damaged.is_empty() {
            return Err(format!("maps are damaged: {damaged:?}"));
        }
        if let Some(notice) =
            state.notices.iter().find(|text| text.contains("damaged") || text.contains("cannot be"))
        {
            return Err(format!("a notice says: {notice}"));
        }
        self.check_stop(state.motion.as_ref(), killed)?;
        self.check_session(sessions, killed, row)?;
        self.check_saving(maps, sessions, killed)?;
        self.check_import(target, killed)?;
        self.check_place(target, killed)?;
        self.check_maps(maps)?;
        self.check_sessions(sessions)
    }

    fn check_stop(&mut self, motion: Option<&Motion>, killed: &Killed) -> Result<(), String> {
        let is_stopped = match motion {
            Some(Motion::Stopped { by }) if *by == Some(CLIENT) => true,
            Some(Motion::Stopped { by }) => return Err(format!("motion is stopped by {by:?}")),
            _ => false,
        };
        if is_stopped != self.expected.is_stopped && killed.stop_in_flight != Some(is_stopped) {
            return Err(format!("the stop of motion should be {}", self.expected.is_stopped));
        }
        self.expected.is_stopped = is_stopped;
        Ok(())
    }

    /// Checks that of a session that ran at most the last second is gone.
    fn check_session(
        &mut self,
        sessions: &[InterruptedSession],
        killed: &Killed,
        row: &mut CaseReport,
    ) -> Result<(), String> {
        let Some(ran) = &killed.session else { return Ok(()) };
        let found = sessions.iter().find(|listed| listed.session == ran.id);
        let published = ran.keyframes.len() as u32;
        row.lost_keyframes = published.saturating_sub(found.map_or(0, |found| found.keyframes));
        if published - row.lost_keyframes.min(published) < ran.certain_keyframes() {
            return Err(format!("of {published} keyframes {} are gone", row.lost_keyframes));
        }
        if let (Some(now), true) = (ran.now, published > 0) {
            let recorded_until = ran.recorded_until.ok_or("nothing of the session is recorded")?;
            let lost_s = (now - recorded_until).secs_f64();
            if lost_s > RECORDING_LOSS_LIMIT_S {
                return Err(format!("the last {lost_s:.2} s of the recording are gone"));
            }
        }
        if let Some(found) = found {
            row.lost_s = if published > 0 { ran.lost_s(found.at) } else { 0.0 };
            if row.lost_s > 1.0 {
                return Err(format!("the last {:.2} s of the session are gone", row.lost_s));
            }
            self.expected.sessions.insert(found.session, found.keyframes);
        }
        Ok(())
    }

    /// Checks that what was being saved is there exactly once, as the session or as the map.
    fn check_saving(
        &mut self,
        maps: &[MapSummary],
        sessions: &[InterruptedSession],
        killed: &Killed,
    ) -> Result<(), String> {
        let Some(saving) = &killed.saving else { return Ok(()) };
        let map = maps.iter().find(|listed| listed.id == saving.map).map(|map| map.keyframes);
        let session = sessions.iter().find(|listed| listed.session == saving.session).map(|s| s.keyframes);
        let ((Some(keyframes), None) | (None, Some(keyframes))) = (map, session) else {
            return Err(format!("what was being saved is there as map {map:?} and as session {session:?}"));
        };
        if keyframes < saving.keyframes || (saving.is_saved && map.is_none()) {
            return Err(format!("of {} keyframes {keyframes} are there", saving.keyframes));
        }
        if map.is_some() {
            self.expected.maps.insert(saving.map, keyframes);
        } else {
            self.expected.sessions.insert(saving.session, keyframes);
        }
        Ok(())
    }

    /// Checks that an import has made its map or kept its file, and that nothing works at it any more. A file that is left is then deleted.
    fn check_import(&mut self, target: &mut Target, killed: &Killed) -> Result<(), String> {
        let Some((upload, name)) = &killed.importing else { return Ok(()) };
        let maps = target.client.state.maps.clone().unwrap_or_default();
        let made: Vec<_> = maps.iter().filter(|map| !self.expected.maps.contains_key(&map.id)).collect();
        let data = self.data();
        let is_file_there = data.join("uploads").join(upload.to_string()).exists();
        match made[..] {
            [] if is_file_there => {}
            [] => return Err("neither the uploaded file nor its map is there".to_owned()),
            [map] if map.name == *name => drop(self.expected.maps.insert(map.id, map.keyframes)),
            _ => return Err(format!("the import has made {made:?}")),
        }
        if let Some(lost) = self.expected.maps_certain.drain(..).find(|map| maps.iter().all(|m| m.id != *map))
        {
            return Err(format!("the imported map {lost} is gone"));
        }
        until("the import's process ends with its core", || {
            processes_of("import", &data).is_empty().then_some(())
        });
        target.client.command(Command::DeleteUpload(*upload))?;
        let left = fs::read_dir(data.join("uploads")).into_iter().flatten().filter_map(Result::ok);
        let left: Vec<_> = left.map(|entry| entry.file_name()).collect();
        if left.is_empty() { Ok(()) } else { Err(format!("uploads/ still has {left:?}")) }
    }

    fn check_place(&mut self, target: &mut Target, killed: &Killed) -> Result<(), String> {
        let Some(map) = killed.localised else { return Ok(()) };
        target
            .client
            .until("the robot is in the map of before", |state| state.localisation.map() == Some(map))
    }

    /// Checks that all maps are there with their files, and that new ones are whole.
    fn check_maps(&mut self, maps: &[MapSummary]) -> Result<(), String> {
        let listed: BTreeMap<_, _> = maps.iter().map(|map| (map.id, map.keyframes)).collect();
        if listed != self.expected.maps {
            return Err(format!("the maps are {listed:?} and not {:?}", self.expected.maps));
        }
        let data = self.data();
        let now = inventory(&data);
        if let Some(change) = first_change(&self.expected.files, &now) {
            return Err(change);
        }
        let files = files_of_maps(&now, &data, listed.keys().copied());
        for map in listed.keys() {
            let summary = Path::new("maps").join(map.to_string()).join("map.json");
            if !self.expected.files.contains_key(&summary) {
                check_whole(&data, *map, KEYFRAMES_OF_A_SECOND)?;
            }
        }
        self.expected.files = files;
        Ok(())
    }

    fn check_sessions(&mut self, sessions: &[InterruptedSession]) -> Result<(), String> {
        let mut listed: BTreeMap<_, _> = sessions.iter().map(|s| (s.session, s.keyframes)).collect();
        if listed != self.expected.sessions {
            return Err(format!(
                "the interrupted sessions are {listed:?} and not {:?}",
                self.expected.sessions
            ));
        }
        std::mem::swap(&mut listed, &mut self.expected.sessions);
        Ok(())
    }

    /// Saves or discards an interrupted session, or leaves it to the next start.
    fn decide(&mut self, target: &mut Target, rng: &mut Rng) -> Result<(), String> {
        let Some((&session, &keyframes)) = self.expected.sessions.last_key_value() else { return Ok(()) };
        let (chance, is_many) = (rng.uniform(), self.expected.sessions.len() > MAX_UNDECIDED_SESSIONS);
        if self.situation == CrashSituation::Saving && self.expected.sessions.len() == 1 {
            return Ok(());
        }
        if chance < 0.5 && keyframes > 0 {
            let (map, name) = (self.new_map(), "Hall".to_owned());
            target.client.command(Command::SaveInterruptedSession { session, map, name, resume_as: None })?;
            self.expected.maps.insert(map, keyframes);
        } else if chance < 0.75 || is_many {
            target.client.command(Command::DiscardInterruptedSession(session))?;
        } else {
            return Ok(());
        }
        self.expected.sessions.remove(&session);
        let is_decided = |list: &Vec<InterruptedSession>| list.iter().all(|listed| listed.session != session);
        target
            .client
            .until("the session is decided on", |state| state.sessions.as_ref().is_some_and(is_decided))?;
        let maps = self.expected.maps.clone();
        target.client.until("the maps are listed", |state| {
            state.maps.iter().flatten().map(|map| (map.id, map.keyframes)).collect::<BTreeMap<_, _>>() == maps
        })?;
        self.check_maps(&target.client.state.maps.clone().unwrap_or_default())
    }

    /// Checks that no temporary file stays for ever, and removes the folder.
    fn check_leftovers(mut self, target: Target) -> Result<(), String> {
        drop(target.kill());
        let data = self.data();
        make_old(&data, &temporary_files(&inventory(&data)));
        let target = self.start(Victim::Core)?;
        self.check_maps(&target.client.state.maps.clone().unwrap_or_default())?;
        drop(target.kill());
        let old = Duration::from_secs(3600);
        let mut left = temporary_files(&inventory(&data));
        left.retain(|file| {
            let modified = fs::metadata(data.join(file)).and_then(|about| about.modified());
            modified.is_ok_and(|modified| modified.elapsed().is_ok_and(|age| age > old))
        });
        if !left.is_empty() {
            return Err(format!("temporary files stay for ever: {left:?}"));
        }
        fs::remove_dir_all(&self.dir).map_err(|error| error.to_string())
    }
}

/// Checks that no map and no session is in its list twice.
fn check_listed_once(maps: &[MapSummary], sessions: &[InterruptedSession]) -> Result<(), String> {
    let mut names: Vec<_> = maps.iter().map(|map| map.id.to_string()).collect();
    names.extend(sessions.iter().map(|session| session.session.to_string()));
    names.sort();
    names
        .windows(2)
        .find(|pair| pair[0] == pair[1])
        .map_or(Ok(()), |pair| Err(format!("{} is listed twice", pair[0])))
}
