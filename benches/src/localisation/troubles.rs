//! What becomes of a robot that is localised in a known map when its LiDAR is covered while it walks, and when it is carried away: put down,
//! it looks about as it would on its way to a goal.

use crate::Arguments;
use crate::known::KnownSite;
use anyhow::{Context, Result};
use benches::stack_walk::{Plan, StackWalk};
use geometry::{Isometry, Rng, RngTree, Vector3, isometry_from_pose, pose_from_isometry};
use messages::{CommandKind, GoalKind, LocalisationState, Publication, StackEffect};
use sim::{ScheduledFault, Site, Start};
use std::sync::Arc;
use uuid::Uuid;
use vocab::{GoalId, Pose, Span, Vec3};

/// Time that a recovery may take, seconds, and how long it is waited for.
const BAR: f64 = 15.0;
const PATIENCE: f64 = 60.0;
/// Whoever is farther off than this does not know its place, metres.
const RIGHT: f64 = 0.2;
/// Covered for so long.
const DARK: Span = Span::from_millis(20_000);
/// Carried so far, metres, for so long.
const AWAY: (f64, f64) = (15.0, 25.0);
const CARRIED: Span = Span::from_millis(12_000);
/// And walked between troubles.
const BETWEEN: Span = Span::from_millis(15_000);

/// Names of the columns: for each trouble how often it came, how far the robot was brought or walked meanwhile (the least of all times,
/// metres, as the crow flies), after how many it knew its place within 15 s, and how long that took; and scans after which it claimed a place that
/// was wrong.
pub fn print_header() {
    println!(
        "{:<8}{:>12}{:>8}{:>9}{:>11}{:>11}{:>9}",
        "site", "trouble", "times", "least m", "in 15 s", "median s", "worst s"
    );
}

/// One trouble: how far it brought the robot, metres, and after how many seconds that knew its place again.
struct Recovery {
    metres: f64,
    seconds: f64,
}

/// What the robot says of its place.
#[derive(Default)]
struct Heard {
    state: LocalisationState,
    estimate: Pose,
    fresh: bool,
}

impl Heard {
    fn hear(&mut self, effects: &[StackEffect]) {
        for effect in effects {
            match effect {
                StackEffect::Publish(Publication::Localisation(state)) => self.state = *state,
                StackEffect::Publish(Publication::Estimate(estimate)) => {
                    self.estimate = estimate.map_from_base
                }
                StackEffect::Publish(Publication::Scan(_)) => self.fresh = true,
                _ => {}
            }
        }
    }

    fn is_sure(&self) -> bool {
        matches!(self.state, LocalisationState::Localised { degradation: None, .. })
    }
}

/// One day with its troubles.
struct Day<'a> {
    walk: StackWalk,
    heard: Heard,
    known: &'a KnownSite,
    /// Scans after which a place was claimed, and of those the ones that were wrong.
    claimed: u64,
    wrong: u64,
    rng: Rng,
    each: bool,
}

impl Day<'_> {
    /// Goes on for so long, a tick at a time; says whether the place was known and right after each of the last scans.
    fn go(&mut self, span: Span) -> Result<bool> {
        let until = self.walk.simulator().elapsed() + span;
        let mut right = false;
        while self.walk.simulator().elapsed() < until {
            let next = self.walk.simulator().elapsed() + Span::from_millis(50);
            let heard = &mut self.heard;
            self.walk.walk(next, &mut |_, _, effects| heard.hear(effects))?;
            if std::mem::take(&mut self.heard.fresh) && self.heard.is_sure() {
                right = self.error()? < RIGHT;
                self.claimed += 1;
                self.wrong += u64::from(!right);
            }
        }
        Ok(right && self.heard.is_sure())
    }

    fn error(&self) -> Result<f64> {
        let estimate = isometry_from_pose(&self.heard.estimate).context("the stack told no pose")?;
        let told: Isometry = self.known.site_from_map * estimate;
        Ok((told.translation.vector - self.walk.site_from_base()?.translation.vector).norm())
    }

    /// Seconds until the robot knows its place again. Where it walks its route it goes on with that, else it looks about.
    fn recovers(&mut self) -> Result<f64> {
        let mut waited = 0.0;
        while waited < PATIENCE {
            if matches!(self.heard.state, LocalisationState::Relocalising { .. }) {
                // As it does by itself on its way to a goal. Whoever looks about already goes on with that.
                let heard = &mut self.heard;
                self.walk.give(
                    CommandKind::StartGoal { goal: GoalId(Uuid::from_u128(1)), kind: GoalKind::Relocalise },
                    &mut |_, _, effects| heard.hear(effects),
                );
            }
            let right = self.go(Span::from_millis(100))?;
            waited += 0.1;
            if right {
                return Ok(waited);
            }
        }
        Ok(f64::INFINITY)
    }

    fn cover(&mut self) -> Result<Recovery> {
        let (from, before) = (self.walk.simulator().elapsed(), self.place()?);
        self.walk.simulator().inject_fault(ScheduledFault::BlindLidar { from, until: from + DARK });
        self.go(DARK)?;
        let metres = (self.place()? - before).norm();
        Ok(Recovery { metres, seconds: self.recovers()? })
    }

    /// Where it truly is in the site.
    fn place(&self) -> Result<Vector3> {
        Ok(self.walk.site_from_base()?.translation.vector)
    }

    /// There and back again; two recoveries, or none where there is nowhere to go.
    fn carry(&mut self) -> Result<Vec<Recovery>> {
        let here = self.walk.site_from_base()?;
        let Some(there) = self.elsewhere(&here.translation.vector) else { return Ok(Vec::new()) };
        self.walk.obey_stack(true);
        let back = start(&here.translation.vector, here.rotation.euler_angles().2);
        let mut took = Vec::new();
        for to in [there, back] {
            let before = self.place()?;
            self.walk.simulator().carry(to, CARRIED);
            self.go(CARRIED)?;
            let metres = (self.place()? - before).norm();
            let seconds = self.recovers()?;
            took.push(Recovery { metres, seconds });
            if self.each {
                self.tell(&to, seconds)?;
            }
            self.walk.give(CommandKind::StopMotion, &mut |_, _, _| {});
            self.walk.give(CommandKind::AllowMotion, &mut |_, _, _| {});
        }
        self.put_back(back)?;
        self.walk.obey_stack(false);
        Ok(took)
    }

    /// Looking about it may have gone anywhere: it is carried to where it left its route, and shown its place.
    fn put_back(&mut self, route: Start) -> Result<()> {
        self.walk.simulator().carry(route, CARRIED);
        self.go(CARRIED)?;
        let map_from_base = self.known.site_from_map.inverse() * self.walk.site_from_base()?;
        let (map, at) = (self.known.known.map, Some(pose_from_isometry(&map_from_base)));
        let heard = &mut self.heard;
        self.walk.give(CommandKind::Localise { map, at }, &mut |_, _, effects| heard.hear(effects));
        self.recovers()?;
        Ok(())
    }

    /// One line: where it was put down, how long it took to know that, and where it is now.
    fn tell(&self, to: &Start, seconds: f64) -> Result<()> {
        let (off, now) = (self.error()?, self.walk.site_from_base()?.translation.vector);
        let Vec3 { x, y, z } = to.position;
        let place = format!("{x:.1},{y:.1},{z:.1}");
        println!("{place:>20}{seconds:>11.1} s{off:>9.3} m off at {:.1},{:.1}", now.x, now.y);
        Ok(())
    }

    /// Some place on this floor that the map shows.
    fn elsewhere(&mut self, here: &Vector3) -> Option<Start> {
        let keyframes = self.known.localisation_map.keyframes();
        let places = keyframes.iter().map(|(pose, _)| (self.known.site_from_map * *pose).translation.vector);
        let site = Arc::clone(self.walk.simulator().site());
        let fits = |place: &Vector3| {
            let away = (place - here).xy().norm();
            let feet = place - Vector3::z() * (here.z - floor_under(&site, here));
            (AWAY.0..AWAY.1).contains(&away) && (place.z - here.z).abs() < 0.2 && site.has_room(&feet)
        };
        let places: Vec<Vector3> = places.filter(fits).collect();
        let index = (self.rng.uniform() * places.len() as f64) as usize;
        let place = places.get(index)?;
        Some(start(place, self.rng.range(0.0, std::f64::consts::TAU)))
    }
}

fn floor_under(site: &Site, base: &Vector3) -> f64 {
    base.z - site.cast_ray(base, &-Vector3::z(), 2.0).map_or(0.0, |(down, _)| down)
}

fn start(place: &Vector3, yaw: f64) -> Start {
    Start { position: Vec3::new(place.x, place.y, place.z), yaw }
}

/// Walks one day with its troubles.
pub fn run(known: &KnownSite, arguments: &Arguments) -> Result<()> {
    let seed = 100 * arguments.seed + 77;
    let site = Arc::new(Site::with_changes(known.site.name(), seed, arguments.moved));
    let plan = Plan { seed, columns: arguments.columns, people: arguments.day_people, keep_truth: false };
    let mut heard = Heard::default();
    let walk =
        StackWalk::localised(&site, "round", &plan, Arc::clone(&known.known), None, &mut |_, _, effects| {
            heard.hear(effects);
        })?;
    let rng = RngTree::new(seed).child("carried").rng();
    let mut day = Day { walk, heard, known, claimed: 0, wrong: 0, rng, each: arguments.each };
    let (mut covered, mut carried) = (Vec::new(), Vec::new());
    for _ in 0..arguments.troubles {
        day.go(BETWEEN)?;
        covered.push(day.cover()?);
        day.go(BETWEEN)?;
        carried.extend(day.carry()?);
    }
    for (trouble, took) in [("covered", covered), ("carried", carried)] {
        print(known, trouble, &took);
    }
    println!("{:<8}{:>12}{:>8}{:>20}", known.site.name(), "wrong scans", day.claimed, day.wrong);
    Ok(())
}

fn print(known: &KnownSite, trouble: &str, recoveries: &[Recovery]) {
    let mut took: Vec<f64> = recoveries.iter().map(|recovery| recovery.seconds).collect();
    took.sort_by(f64::total_cmp);
    let at =
        |share: f64| took.get((share * (took.len().max(1) - 1) as f64) as usize).copied().unwrap_or(f64::NAN);
    let in_time = took.iter().filter(|seconds| **seconds <= BAR).count();
    let metres = recoveries.iter().map(|recovery| recovery.metres).fold(f64::INFINITY, f64::min);
    println!(
        "{:<8}{:>12}{:>8}{:>9.1}{:>11}{:>11.1}{:>9.1}",
        known.site.name(),
        trouble,
        took.len(),
        metres,
        in_time,
        at(0.5),
        at(1.0)
    );
}
