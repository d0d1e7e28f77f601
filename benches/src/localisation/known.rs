//! A simulated site and the map that the stack made of it.

use crate::Arguments;
use anyhow::{Context, Result};
use benches::stack_walk::{Plan, StackWalk};
use geometry::{Isometry, isometry_from_pose};
use localisation::LocalisationMap;
use mapping::{KeyframeDescriptor, KeyframeDescriptorParts};
use messages::{PriorKeyframe, PriorMap, Publication, StackEffect};
use sim::{Site, SiteName};
use std::collections::BTreeMap;
use std::sync::Arc;
use vocab::Span;

/// A site with its map.
pub struct KnownSite {
    pub site: Arc<Site>,
    pub localisation_map: Arc<LocalisationMap>,
    /// As the stack reads it.
    pub known: Arc<PriorMap>,
    pub site_from_map: Isometry,
}

impl KnownSite {
    /// Walks the site's round and keeps the map.
    pub fn map(name: SiteName, arguments: &Arguments) -> Result<Self> {
        let site = Arc::new(Site::new(name));
        let plan = Plan {
            seed: arguments.seed,
            columns: arguments.columns,
            people: arguments.people,
            keep_truth: true,
        };
        let mut places = BTreeMap::new();
        let mut heard = |_, _, effects: &[StackEffect]| {
            for effect in effects {
                let StackEffect::Publish(Publication::Keyframe(keyframe)) = effect else { continue };
                let (pose, xyz) = (&keyframe.map_from_keyframe, &keyframe.cloud.xyz);
                places.extend(
                    stack::encode_prior_keyframe(pose, xyz, keyframe.lidar).map(|place| (keyframe.id, place)),
                );
            }
        };
        let mut walk = StackWalk::new(&site, "round", &plan, &mut heard)?;
        walk.walk(Span::from_secs_f64(arguments.minutes * 60.0), &mut heard)?;
        let (finished, truth) = walk.finish(&mut heard)?;
        let (mut keyframes, mut pairs, mut kept) = (Vec::new(), Vec::new(), Vec::new());
        for node in &finished.graph.nodes {
            let map_from_keyframe =
                isometry_from_pose(&node.map_from_keyframe).context("a keyframe has no pose")?;
            let place = places.remove(&node.id).context("a keyframe has no cloud")?;
            let site_from_keyframe = truth.at(node.stamp).context("no truth was kept")?;
            pairs.push((site_from_keyframe.translation.vector, map_from_keyframe.translation.vector));
            let PriorKeyframe { lidar, points, ranges, views } = place.clone();
            let parts = KeyframeDescriptorParts { points, ranges, views };
            keyframes.push((
                map_from_keyframe,
                KeyframeDescriptor::from_parts(parts, lidar).context("a place is broken")?,
            ));
            kept.push(place);
        }
        let alignment = geometry::umeyama(&pairs, false).context("the walk was too short")?;
        let site_from_map = alignment.truth_from_estimate;
        let (map, graph) = (finished.map, finished.graph.as_ref().clone());
        let known = Arc::new(PriorMap { map, graph, places: kept });
        Ok(Self { site, localisation_map: Arc::new(LocalisationMap::new(keyframes)), known, site_from_map })
    }
}
