//! What the program does when it is killed.

use super::case::{CrashSession, CrashSituation, Killed, SavedAs, drive, map_until};
use super::chain::Chain;
use super::client::{CoreClient, CoreState};
use super::target::{Target, processes_of};
use api::{Command, Import, Localisation};
use geometry::Rng;
use std::time::{Duration, Instant};

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
            CrashSituation::Mapping => self.kill_while_mapping(target, rng),
            CrashSituation::Saving if rng.uniform() < 0.5 => self.kill_while_finishing(target, rng),
            CrashSituation::Saving => self.kill_while_saving_interrupted(target, rng),
            CrashSituation::Localising => self.kill_while_localising(target, rng),
            CrashSituation::Importing => self.kill_while_importing(target, rng),
            CrashSituation::Idle if rng.uniform() < 0.3 => self.kill_while_starting(target, rng),
            CrashSituation::Idle => self.kill_while_stopping_motion(target, rng),
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
        let session = Some(CrashSession::of(id, &state, &self.data()));
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
        let session = CrashSession::of(id, &state, &self.data());
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
