//! What the program does when it is killed.

use super::chain::{Chain, SavedAs};
use super::client::{CoreClient, CoreState};
use super::inventory::recorded_until;
use super::target::{Target, processes_of};
use api::{Command, Import, Localisation};
use geometry::Rng;
use std::path::Path;
use std::time::{Duration, Instant};
use vocab::{MapId, SessionId, Span, Stamp, Twist, UploadId, Vec3};

/// Longest time of a mapping session that a kill may lose.
const LOSS_LIMIT: Span = Span::from_millis(1000);

/// What the program does when it is killed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Situation {
    Mapping,
    Saving,
    Localising,
    Importing,
    Idle,
}

impl Situation {
    pub fn name(self) -> &'static str {
        match self {
            Self::Mapping => "mapping",
            Self::Saving => "saving",
            Self::Localising => "localising",
            Self::Importing => "importing",
            Self::Idle => "idle",
        }
    }
}

/// What has to hold after the next start.
#[derive(Default)]
pub struct Killed {
    /// What was killed and when.
    pub what: String,
    /// A session that ran.
    pub session: Option<RunningSession>,
    /// What was being saved: afterwards there is the session or the map.
    pub saving: Option<SavedAs>,
    /// The file of which a map was being made, and the map's name.
    pub importing: Option<(UploadId, String)>,
    /// The map that the robot must know to be in, if that is certain; or that it may be in.
    pub localised: Option<MapId>,
    /// State of the stop of motion that was being written.
    pub stop_in_flight: Option<bool>,
}

/// What clients had seen of a session when its process was killed.
pub struct RunningSession {
    pub id: SessionId,
    /// Instants of its keyframes.
    pub keyframes: Vec<Stamp>,
    /// Instant of the newest estimate.
    pub now: Option<Stamp>,
    /// Instant of the last recorded input; of the first estimate if none was recorded.
    pub recorded_until: Option<Stamp>,
}

impl RunningSession {
    fn of(id: SessionId, state: &CoreState, data: &Path) -> Self {
        let keyframes = state.keyframes.values().copied().collect();
        Self { id, keyframes, now: state.now, recorded_until: recorded_until(data).or(state.began) }
    }

    /// Keyframes that must be there after a kill: those older than the second that may be lost.
    pub fn certain_keyframes(&self) -> u32 {
        let is_certain = |stamp: &&Stamp| self.now.is_some_and(|now| now - **stamp > LOSS_LIMIT);
        self.keyframes.iter().filter(is_certain).count() as u32
    }

    /// Time of the session that is gone, seconds.
    pub fn lost_s(&self, recovered_until: Stamp) -> f64 {
        self.now.map_or(0.0, |now| (now - recovered_until).secs_f64().max(0.0))
    }
}

/// A slow walk on a circle, which stays where the map is.
pub fn drive(client: &mut CoreClient) {
    let velocity = Twist { linear: Vec3::new(0.6, 0.0, 0.0), angular: Vec3::new(0.0, 0.0, 0.3) };
    client.send(Command::Teleoperate(velocity));
}

/// Begins a session, and walks until it has some keyframes.
pub fn map_until(client: &mut CoreClient, session: SessionId, keyframes: usize) -> Result<(), String> {
    client.command(Command::TakeControl { name: "Test".to_owned() })?;
    client.command(Command::StartMapping(session))?;
    client.until_with("keyframes", drive, |state| state.keyframes.len() >= keyframes)
}

/// A time up to this one.
fn time_up_to(rng: &mut Rng, longest: Duration) -> Duration {
    longest.mul_f64(rng.uniform())
}

impl Chain {
    /// Brings the program into the situation of a case and kills it. If it still runs afterwards, the target is returned as well.
    pub fn kill(&mut self, mut target: Target, rng: &mut Rng) -> Result<(Killed, Option<Target>), String> {
        if self.expected.is_stopped {
            // A stop of an earlier case has been checked by now.
            target.client.command(Command::TakeControl { name: "Test".to_owned() })?;
            target.client.command(Command::AllowMotion)?;
            self.expected.is_stopped = false;
        }
        match self.situation {
            Situation::Mapping => self.kill_while_mapping(target, rng),
            Situation::Saving if rng.uniform() < 0.5 => self.kill_while_finishing(target, rng),
            Situation::Saving => self.kill_while_saving_interrupted(target, rng),
            Situation::Localising => self.kill_while_localising(target, rng),
            Situation::Importing => self.kill_while_importing(target, rng),
            Situation::Idle if rng.uniform() < 0.3 => self.kill_while_starting(target, rng),
            Situation::Idle => self.kill_while_stopping_motion(target, rng),
        }
    }

    /// In some cases somebody stops motion before the kill. The stop must hold afterwards.
    fn perhaps_stop_motion(&mut self, client: &mut CoreClient, rng: &mut Rng) -> Result<(), String> {
        if rng.uniform() < 0.3 {
            client.command(Command::StopMotion)?;
            self.expected.is_stopped = true;
        }
        Ok(())
    }

    fn kill_while_mapping(&mut self, mut target: Target, rng: &mut Rng) -> Step {
        let id = self.new_session();
        let is_early = rng.uniform() < 0.2;
        let keyframes = 1 + (rng.uniform() * 3.0) as usize;
        let client = &mut target.client;
        if is_early {
            client.command(Command::TakeControl { name: "Test".to_owned() })?;
            client.send(Command::StartMapping(id));
        } else {
            map_until(client, id, keyframes)?;
        }
        client.for_time(time_up_to(rng, Duration::from_millis(800)), drive)?;
        self.perhaps_stop_motion(client, rng)?;
        client.for_time(time_up_to(rng, Duration::from_millis(100)), |_| {})?;
        let victim = self.victim.name();
        let state = target.kill().read_to_end();
        let what = format!("{victim} at {} keyframes", state.keyframes.len());
        let session = Some(RunningSession::of(id, &state, &self.data()));
        Ok((Killed { what, session, ..Killed::default() }, None))
    }

    fn kill_while_finishing(&mut self, mut target: Target, rng: &mut Rng) -> Step {
        let (id, map) = (self.new_session(), self.new_map());
        let client = &mut target.client;
        map_until(client, id, 2)?;
        self.perhaps_stop_motion(client, rng)?;
        client.send(Command::FinishMapping { map, name: "Hall".to_owned() });
        let after = time_up_to(rng, self.times.finish.mul_f64(1.3));
        client.for_time(after, |_| {})?;
        let what = format!("{} {} ms after finishing", self.victim.name(), after.as_millis());
        let state = target.kill().read_to_end();
        let session = RunningSession::of(id, &state, &self.data());
        let keyframes = session.certain_keyframes();
        let is_saved = state.maps.iter().flatten().any(|listed| listed.id == map);
        let saving = Some(SavedAs { session: id, map, keyframes, is_saved });
        Ok((Killed { what, saving, ..Killed::default() }, None))
    }

    fn kill_while_saving_interrupted(&mut self, mut target: Target, rng: &mut Rng) -> Step {
        let Some((&session, &keyframes)) = self.expected.sessions.first_key_value() else {
            return Err("no interrupted session is there to be saved".to_owned());
        };
        let map = self.new_map();
        let client = &mut target.client;
        self.perhaps_stop_motion(client, rng)?;
        let name = "Hall".to_owned();
        client.send(Command::SaveInterruptedSession { session, map, name, resume_as: None });
        let after = time_up_to(rng, self.times.save_interrupted.mul_f64(1.3));
        client.for_time(after, |_| {})?;
        let what = format!("{} {} ms after saving an interrupted one", self.victim.name(), after.as_millis());
        let state = target.kill().read_to_end();
        let is_saved = state.maps.iter().flatten().any(|listed| listed.id == map);
        self.expected.sessions.remove(&session);
        let saving = Some(SavedAs { session, map, keyframes, is_saved });
        Ok((Killed { what, saving, ..Killed::default() }, None))
    }

    fn kill_while_localising(&mut self, mut target: Target, rng: &mut Rng) -> Step {
        let map = self.first_map();
        let client = &mut target.client;
        client.command(Command::TakeControl { name: "Test".to_owned() })?;
        let is_early = rng.uniform() < 0.5;
        if is_early || client.state.localisation.map() != Some(map) {
            if client.state.localisation.map().is_some() {
                client.command(Command::LeaveMap)?;
            }
            client.command(Command::Localise { map, at: None })?;
        }
        if !is_early {
            let is_localised =
                |state: &CoreState| matches!(state.localisation, Localisation::Localised { .. });
            client.until("the robot is localised", is_localised)?;
        }
        self.perhaps_stop_motion(client, rng)?;
        client.for_time(time_up_to(rng, Duration::from_millis(2500)), drive)?;
        let what = format!("{} {}", self.victim.name(), if is_early { "relocalising" } else { "localised" });
        let killed_at = Instant::now();
        let state = target.kill().read_to_end();
        // The pose is written with the first estimate after the robot was localised, and every 2 s then.
        let is_certain =
            state.localised_since.is_some_and(|since| killed_at - since > Duration::from_secs(1));
        Ok((Killed { what, localised: is_certain.then_some(map), ..Killed::default() }, None))
    }

    fn kill_while_importing(&mut self, mut target: Target, rng: &mut Rng) -> Step {
        let kills_import = rng.uniform() < 0.35;
        let (upload, name) = self.upload_room();
        let client = &mut target.client;
        self.perhaps_stop_motion(client, rng)?;
        client.command(Command::ImportMap { upload, name: name.clone(), frame: None })?;
        let after = time_up_to(rng, self.times.import.mul_f64(1.2));
        client.for_time(after, |_| {})?;
        let importing = Some((upload, name));
        if kills_import {
            let what = format!("import after {} ms", after.as_millis());
            for process in processes_of("import", &self.data()) {
                // It may have ended by itself.
                let process = rustix::process::Pid::from_raw(process as i32).expect("not zero");
                let _ = rustix::process::kill_process(process, rustix::process::Signal::KILL);
            }
            client.until("the outcome of the import", |state| {
                matches!(&state.import, Import::Done { upload: of, .. } | Import::Failed { upload: of, .. } if *of == upload)
            })?;
            return Ok((Killed { what, importing, ..Killed::default() }, Some(target)));
        }
        let what = format!("{} {} ms after an import began", self.victim.name(), after.as_millis());
        let state = target.kill().read_to_end();
        if let Import::Done { upload: of, map } = state.import
            && of == upload
        {
            self.expected.maps_certain.push(map);
        }
        Ok((Killed { what, importing, ..Killed::default() }, None))
    }

    fn kill_while_starting(&mut self, target: Target, rng: &mut Rng) -> Step {
        drop(target.kill());
        let after = time_up_to(rng, self.times.start.mul_f64(1.2));
        Target::kill_while_starting(&self.dir, after);
        let what = format!("core {} ms after its start", after.as_millis());
        Ok((Killed { what, ..Killed::default() }, None))
    }

    fn kill_while_stopping_motion(&mut self, mut target: Target, rng: &mut Rng) -> Step {
        let client = &mut target.client;
        client.command(Command::TakeControl { name: "Test".to_owned() })?;
        let command = |is_stopped| if is_stopped { Command::StopMotion } else { Command::AllowMotion };
        for _ in 0..(rng.uniform() * 3.0) as usize {
            self.expected.is_stopped = !self.expected.is_stopped;
            client.command(command(self.expected.is_stopped))?;
        }
        let in_flight = !self.expected.is_stopped;
        let id = client.send(command(in_flight));
        let after = time_up_to(rng, Duration::from_millis(30));
        client.for_time(after, |_| {})?;
        let what = format!("{} {} ms after a command", self.victim.name(), after.as_millis());
        let state = target.kill().read_to_end();
        let stop_in_flight = if CoreClient::is_accepted(&state, id) {
            self.expected.is_stopped = in_flight;
            None
        } else {
            Some(in_flight)
        };
        Ok((Killed { what, stop_in_flight, ..Killed::default() }, None))
    }
}

/// What was killed, and the program if it still runs.
type Step = Result<(Killed, Option<Target>), String>;
