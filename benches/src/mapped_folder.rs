//! A map of a simulated site in a folder, as `autoinspect map --out` writes it, kept for the next run.

use crate::stack_walk::{StackWalk, StepKind, WalkPlan};
use anyhow::{Context, Result};
use geometry::{Isometry, isometry_from_pose, pose_from_isometry};
use messages::{Publication, StackEffect};
use serde::{Deserialize, Serialize};
use site_files::SiteSource;
use std::fs;
use std::path::{Path, PathBuf};
use store::{MapFileOptions, TileFiles, write_cloud, write_map_files};
use vocab::{Pose, Span};

/// What is known of the truth; not part of the map.
#[derive(Serialize, Deserialize)]
struct Truth {
    site_from_map: Pose,
    docks: Vec<Pose>,
}

/// The walk that makes a map.
#[derive(Clone, Copy, Debug)]
pub struct MapPlan {
    /// Seed of the simulation.
    pub seed: u64,
    /// Length of the walk, minutes.
    pub minutes: f64,
    /// LiDAR columns per sweep.
    pub columns: u32,
    /// Number of people who walk on the site.
    pub people: u32,
}

/// A mapped site.
pub struct MappedFolder {
    /// Folder of the map.
    pub path: PathBuf,
    /// The best rigid alignment of the map with the site.
    pub site_from_map: Isometry,
    /// Poses of the base on the docks, in the map.
    pub docks: Vec<Isometry>,
}

impl MappedFolder {
    /// The map of a site, made now if it is not in the folder `work`.
    ///
    /// # Errors
    /// When the site cannot be loaded or mapped, or the folder cannot be read or written.
    pub fn of(source: &SiteSource, work: &Path, plan: &MapPlan) -> Result<Self> {
        let MapPlan { seed, minutes, columns, people } = *plan;
        let name = source.to_string().replace([':', '/'], "-");
        let path = work.join(format!("{name}-{seed}-{minutes}-{columns}-{people}"));
        let file = path.join("truth.json");
        if !file.exists() {
            let _ = fs::remove_dir_all(&path);
            make(source, &path, plan)?;
        }
        let truth: Truth = serde_json::from_slice(&fs::read(&file)?)?;
        let pose = |pose: &Pose| isometry_from_pose(pose).context("a pose of truth.json is none");
        Ok(Self {
            path,
            site_from_map: pose(&truth.site_from_map)?,
            docks: truth.docks.iter().map(pose).collect::<Result<_>>()?,
        })
    }
}

/// Maps a site with the whole stack.
fn make(source: &SiteSource, path: &Path, plan: &MapPlan) -> Result<()> {
    let site = source.load()?;
    let clouds = path.join("clouds");
    fs::create_dir_all(&clouds)?;
    let MapPlan { seed, minutes, columns, people } = *plan;
    let plan = WalkPlan { seed, columns, people, keep_ground_truth: true };
    let mut failed = None;
    let mut observer = |_: StepKind, _: f64, effects: &[StackEffect]| {
        for effect in effects {
            if let StackEffect::Publish(Publication::Keyframe(keyframe)) = effect {
                failed = write_cloud(&clouds, keyframe).err().or(failed.take());
            }
        }
    };
    let mut walk = StackWalk::new(&site, "round", &plan, &mut observer)?;
    walk.walk_until(Span::from_secs_f64(60.0 * minutes), &mut observer)?;
    let (finished, truth) = walk.finish(&mut observer)?;
    if let Some(error) = failed {
        return Err(error.into());
    }
    write_map_files(path, &TileFiles::new(path.join("tiles")), &finished, MapFileOptions::default())?;
    let mut positions = Vec::new();
    for node in &finished.graph.nodes {
        let found = isometry_from_pose(&node.map_from_keyframe).context("a keyframe has no pose")?;
        let place = truth.interpolate(node.stamp).context("no ground truth was kept")?;
        positions.push((place.translation.vector, found.translation.vector));
    }
    let alignment = geometry::umeyama(&positions, false).context("the walk was too short")?;
    let site_from_map = alignment.truth_from_estimate;
    // The base stands over the dock as high as where the walk began.
    let start = isometry_from_pose(&finished.graph.nodes[0].map_from_keyframe).context("no keyframe")?;
    let docks = site.docks().iter().map(|dock| {
        let at = geometry::vec_from_plain(dock.position);
        let heading = geometry::Rotation::from_euler_angles(0.0, 0.0, dock.yaw);
        let mut map_from_dock = site_from_map.inverse() * Isometry::from_parts(at.into(), heading);
        map_from_dock.translation.vector.z += sim::STANDING_HEIGHT;
        // The first dock is where the walk began.
        let is_first = (map_from_dock.translation.vector - start.translation.vector).norm() < 0.3;
        pose_from_isometry(if is_first { &start } else { &map_from_dock })
    });
    let truth = Truth { site_from_map: pose_from_isometry(&site_from_map), docks: docks.collect() };
    fs::write(path.join("truth.json"), serde_json::to_vec(&truth)?)?;
    Ok(())
}
