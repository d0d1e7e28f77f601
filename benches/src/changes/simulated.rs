//! Visits of simulated sites: a robot walks the round of a site again and again, localised in its map, with people about, and between two visits objects are put, taken, moved and
//! turned. What the clouds that a mission keeps say of it is compared with the truth.

use super::visit_cache;
use super::visit_score::{VisitScore, score_visit};
use anyhow::{Context, Result};
use benches::cast_visits::cast_visit;
use benches::mapped_site::MappedSite;
use benches::stack_walk::{StackWalk, StepKind, WalkExtent, WalkPlan};
use benches::thread_ms;
use changes::{ChangesConfig, SensorView, Visit, detect_changes};
use geometry::{Isometry, Vector3, isometry_from_pose};
use messages::{CorrectedScan, LocalisationState, Publication, StackEffect};
use nalgebra::Point3;
use sim::{LooseObjectsConfig, SimulatedSite, SiteName};
use std::path::PathBuf;
use std::sync::Arc;
use vocab::{Pose, Span};

/// Distance between two clouds of a visit, metres, as missions keep them.
const CLOUD_DISTANCE_M: f64 = 2.0;
/// Loose objects on a site before the first visit.
const FIRST_OBJECTS: usize = 12;

/// Which visits are walked.
#[derive(Clone, Debug)]
pub struct Plan {
    pub sites: Vec<SiteName>,
    /// Visits of each site.
    pub visits: u32,
    /// Changes between two visits.
    pub changes: usize,
    pub seed: u64,
    pub columns: u32,
    pub people: u32,
    /// Time of a walk, seconds; the whole round if none.
    pub walk_s: Option<f64>,
    pub explain: bool,
    /// Whether sweeps are cast from places along the whole round, without the stack.
    pub cast: bool,
    /// Folder in which the clouds of walks are kept.
    pub cache: Option<PathBuf>,
}

impl Plan {
    fn extent(&self) -> WalkExtent {
        self.walk_s.map_or(WalkExtent::Round, |walk_s| WalkExtent::Time(Span::from_secs_f64(walk_s)))
    }
}

/// Walks all visits. Prints a row for each comparison.
pub fn run(plan: &Plan) -> Result<VisitScore> {
    println!(
        "| site | visit | clouds | points | changed | found | of 0.15 m | found | moved | matched | turned | found | of 0.15 m | found | unseen | wrong | compared in |"
    );
    println!(
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |"
    );
    let mut total = VisitScore::default();
    for name in &plan.sites {
        let mut of_site = VisitScore::default();
        visit_site(*name, plan, &mut of_site)?;
        print_row(&name.to_string(), "all", "", "", &of_site, "");
        total.add(&of_site);
    }
    Ok(total)
}

fn visit_site(name: SiteName, plan: &Plan, score: &mut VisitScore) -> Result<()> {
    let objects = LooseObjectsConfig::default();
    let usual = SimulatedSite::new(name).with_loose_objects(plan.seed, FIRST_OBJECTS, &objects);
    let mut site = Arc::new(usual);
    let walk = WalkPlan { seed: plan.seed, columns: plan.columns, people: 0, keep_ground_truth: true };
    let mut mapped = Mapped { site: Arc::clone(&site), walk, extent: plan.extent(), made: None };
    let mut before: Option<Visit> = None;
    for visit in 0..plan.visits {
        let seed = 1_000 * plan.seed + u64::from(visit);
        let truth = match &before {
            None => Vec::new(),
            Some(_) => site.random_changes(seed, plan.changes, &objects),
        };
        site = Arc::new(site.with_changes(&truth));
        let after = kept_visit(&site, &mut mapped, plan, seed)?;
        if let Some(before) = &before {
            let begun_ms = thread_ms();
            let found = detect_changes(before, &after, &ChangesConfig::default());
            let seconds = (thread_ms() - begun_ms) / 1e3;
            let mut notes = Vec::new();
            let of_visit = score_visit(&found.objects, &truth, [before, &after], |note| notes.push(note));
            let (clouds, points) = (after.views.len().to_string(), after.len().to_string());
            print_row(
                &name.to_string(),
                &visit.to_string(),
                &clouds,
                &points,
                &of_visit,
                &format!("{seconds:.1} s"),
            );
            for note in notes.iter().filter(|_| plan.explain) {
                println!("  {note}");
            }
            score.add(&of_visit);
        }
        before = Some(after);
    }
    Ok(())
}

fn print_row(site: &str, visit: &str, clouds: &str, points: &str, score: &VisitScore, compared: &str) {
    let VisitScore {
        large,
        large_found,
        small,
        small_found,
        moved,
        matched,
        turned,
        turned_found,
        small_turned,
        small_turned_found,
        unseen,
        wrong,
        ..
    } = score;
    println!(
        "| {site} | {visit} | {clouds} | {points} | {large} | {large_found} | {small} | {small_found} | {moved} | {matched} | {turned} | {turned_found} | {small_turned} | {small_turned_found} | {unseen} | {wrong} | {compared} |"
    );
}

/// The clouds of a walk: one every 2 m while the robot is localised well.
struct KeptClouds {
    base_from_lidar: Isometry,
    is_localised: bool,
    last: Option<Vector3>,
    visit: Visit,
}

impl KeptClouds {
    fn watch(&mut self, effects: &[StackEffect]) {
        for effect in effects {
            match effect {
                StackEffect::Publish(Publication::Localisation(state)) => {
                    self.is_localised =
                        matches!(state, LocalisationState::Localised { degradation: None, .. });
                }
                StackEffect::Publish(Publication::Scan(scan)) if self.is_localised => self.keep(scan),
                _ => {}
            }
        }
    }

    fn keep(&mut self, scan: &CorrectedScan) {
        let Some(map_from_base) = isometry_from_pose(&scan.map_from_base) else { return };
        let at = map_from_base.translation.vector;
        if self.last.is_some_and(|last| (at - last).norm() < CLOUD_DISTANCE_M) {
            return;
        }
        self.last = Some(at);
        let sensor = (map_from_base * Point3::from(self.base_from_lidar.translation.vector)).coords;
        let in_map = |point: &[f32; 3]| {
            (map_from_base * Point3::from(point.map(f64::from))).coords.map(|at| at as f32).into()
        };
        let points = scan.cloud.xyz.iter().map(in_map).collect();
        self.visit.views.push(SensorView { sensor, points });
    }
}

/// The map of a site, made when it is needed first.
struct Mapped {
    site: Arc<SimulatedSite>,
    walk: WalkPlan,
    extent: WalkExtent,
    made: Option<MappedSite>,
}

impl Mapped {
    fn get(&mut self) -> Result<&MappedSite> {
        if self.made.is_none() {
            self.made = Some(MappedSite::new(Arc::clone(&self.site), &self.walk, self.extent)?);
        }
        self.made.as_ref().context("it was just made")
    }
}

/// A visit from the folder of walks, or walked now, in the frame of the site.
fn kept_visit(site: &Arc<SimulatedSite>, mapped: &mut Mapped, plan: &Plan, seed: u64) -> Result<Visit> {
    let walk = match plan.walk_s {
        _ if plan.cast => "cast".to_owned(),
        Some(walk_s) => walk_s.to_string(),
        None => "round".to_owned(),
    };
    let name = format!("{}-{seed}-{}-{}-{}-{walk}", site.name(), plan.changes, plan.columns, plan.people);
    let file = plan.cache.as_ref().map(|folder| folder.join(name));
    if let Some(visit) = file.as_deref().map(visit_cache::read).transpose()?.flatten() {
        return Ok(visit);
    }
    let visit = if plan.cast {
        cast_visit(site, plan.columns, plan.people, seed)?
    } else {
        walk_visit(site, mapped.get()?, plan, seed)?
    };
    if let Some(file) = file {
        visit_cache::write(&file, &visit)?;
    }
    Ok(visit)
}

fn walk_visit(site: &Arc<SimulatedSite>, mapped: &MappedSite, plan: &Plan, seed: u64) -> Result<Visit> {
    let walk = WalkPlan { seed, columns: plan.columns, people: plan.people, keep_ground_truth: false };
    let start = site.route("round").context("the site has no round")?.start;
    let mut kept = KeptClouds {
        base_from_lidar: Isometry::identity(),
        is_localised: false,
        last: None,
        visit: Visit::default(),
    };
    let site_from_start = Isometry::new(
        Vector3::new(start.position.x, start.position.y, start.position.z + sim::STANDING_HEIGHT),
        Vector3::new(0.0, 0.0, start.yaw),
    );
    let prior: Pose = geometry::pose_from_isometry(&(mapped.site_from_map.inverse() * site_from_start));
    let mut walker = StackWalk::localised(
        site,
        "round",
        &walk,
        Arc::clone(&mapped.prior_map),
        Some(prior),
        &mut |_: StepKind, _: f64, effects: &[StackEffect]| kept.watch(effects),
    )?;
    let boot = walker.simulator().boot();
    kept.base_from_lidar =
        boot.mounting.base_from_lidar.and_then(|pose| isometry_from_pose(&pose)).unwrap_or_default();
    walker.walk(plan.extent(), &mut |_, _, effects: &[StackEffect]| kept.watch(effects))?;
    // The map's own frame may be turned and tilted a little; the truth is in that of the site.
    Ok(in_frame(kept.visit, &mapped.site_from_map))
}

fn in_frame(mut visit: Visit, frame_from_visit: &Isometry) -> Visit {
    for view in &mut visit.views {
        view.sensor = (frame_from_visit * Point3::from(view.sensor)).coords;
        for point in &mut view.points {
            *point =
                (frame_from_visit * Point3::from(point.map(f64::from))).coords.map(|at| at as f32).into();
        }
    }
    visit
}

#[cfg(test)]
mod nightly {
    use super::*;

    #[test]
    fn a_few_changes_at_b1_are_found_and_nothing_else_is() {
        let plan = Plan {
            sites: vec![SiteName::B1],
            visits: 2,
            changes: 3,
            seed: 1,
            columns: 400,
            people: 2,
            walk_s: None,
            explain: true,
            cast: true,
            cache: None,
        };
        let score = run(&plan).expect("b1 has a round");
        assert!(score.large > 0 && score.large_found == score.large, "{score:?}");
        assert_eq!(score.wrong, 0, "{score:?}");
    }
}
