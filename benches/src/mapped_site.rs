//! A simulated site and the map that the stack makes of it.

use crate::map_score::{MapScore, score_map};
use crate::prior_map::PriorMapBuilder;
use crate::stack_walk::{StackWalk, StepKind, WalkExtent, WalkPlan, reanchorings};
use anyhow::{Context, Result};
use geometry::{Isometry, isometry_from_pose};
use localisation::LocalisationMap;
use mapping::{KeyframeDescriptor, KeyframeDescriptorParts};
use messages::{PriorKeyframe, PriorMap, StackEffect};
use sim::SimulatedSite;
use std::sync::Arc;

/// A site with its map.
pub struct MappedSite {
    /// The site.
    pub site: Arc<SimulatedSite>,
    /// The map, to localise in.
    pub localisation_map: Arc<LocalisationMap>,
    /// The map in the form in which the stack reads it from disk.
    pub prior_map: Arc<PriorMap>,
    /// The best rigid alignment of the map with the site.
    pub site_from_map: Isometry,
    /// How accurate the map is.
    pub score: MapScore,
}

impl MappedSite {
    /// Maps the site while the robot walks its round.
    ///
    /// # Errors
    /// When the site has no round, or the stack makes no map.
    pub fn new(site: Arc<SimulatedSite>, plan: &WalkPlan, extent: WalkExtent) -> Result<Self> {
        let plan = WalkPlan { keep_ground_truth: true, ..*plan };
        let (mut builder, mut reanchored) = (PriorMapBuilder::default(), Vec::new());
        let mut observer = |_: StepKind, _: f64, effects: &[StackEffect]| {
            builder.insert(effects);
            reanchored.extend(reanchorings(effects).copied());
        };
        let mut walk = StackWalk::new(&site, "round", &plan, &mut observer)?;
        walk.walk(extent, &mut observer)?;
        let (finished, truth) = walk.finish(&mut observer)?;
        let score = score_map(&site, &finished, &truth, &reanchored)?;
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
            score,
        })
    }
}
