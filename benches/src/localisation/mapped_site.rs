//! A simulated site and the map that the stack makes of it.

use crate::arguments::Arguments;
use anyhow::{Context, Result};
use benches::prior_map::PriorMapBuilder;
use benches::stack_walk::{StackWalk, StepKind, WalkPlan};
use geometry::{Isometry, isometry_from_pose};
use localisation::LocalisationMap;
use mapping::{KeyframeDescriptor, KeyframeDescriptorParts};
use messages::{PriorKeyframe, PriorMap, StackEffect};
use sim::{Site, SiteName};
use std::sync::Arc;
use vocab::Span;

/// A site with its map.
pub struct MappedSite {
    pub site: Arc<Site>,
    pub localisation_map: Arc<LocalisationMap>,
    /// The map in the form in which the stack reads it from disk.
    pub prior_map: Arc<PriorMap>,
    pub site_from_map: Isometry,
}

impl MappedSite {
    /// Maps the site while the robot walks its round.
    pub fn new(name: SiteName, arguments: &Arguments) -> Result<Self> {
        let site = Arc::new(Site::new(name));
        let plan = WalkPlan {
            seed: arguments.seed,
            columns: arguments.columns,
            people: arguments.people,
            keep_ground_truth: true,
        };
        let mut builder = PriorMapBuilder::default();
        let mut observer = |_: StepKind, _: f64, effects: &[StackEffect]| builder.insert(effects);
        let mut walk = StackWalk::new(&site, "round", &plan, &mut observer)?;
        walk.walk_until(Span::from_secs_f64(arguments.minutes * 60.0), &mut observer)?;
        let (finished, truth) = walk.finish(&mut observer)?;
        let prior_map = builder.build(&finished)?;
        let (mut keyframes, mut positions) = (Vec::new(), Vec::new());
        for (node, place) in prior_map.graph.nodes.iter().zip(&prior_map.keyframes) {
            let map_from_keyframe =
                isometry_from_pose(&node.map_from_keyframe).context("a keyframe has no pose")?;
            let site_from_keyframe = truth.interpolate(node.stamp).context("no ground truth was kept")?;
            positions.push((site_from_keyframe.translation.vector, map_from_keyframe.translation.vector));
            let PriorKeyframe { lidar, points, ranges, views } = place.clone();
            let parts = KeyframeDescriptorParts { points, ranges, views };
            let descriptor = KeyframeDescriptor::from_parts(parts, lidar).context("a keyframe is damaged")?;
            keyframes.push((map_from_keyframe, descriptor));
        }
        let alignment = geometry::umeyama(&positions, false).context("the walk was too short")?;
        Ok(Self {
            site,
            localisation_map: Arc::new(LocalisationMap::new(keyframes)),
            prior_map: Arc::new(prior_map),
            site_from_map: alignment.truth_from_estimate,
        })
    }
}
