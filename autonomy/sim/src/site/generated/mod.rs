//! `generated:SEED`: buildings drawn from a seed. Each has two floors joined by stairs, corridors, rooms of several uses, and mostly a hall.
//!
//! Nobody tunes an algorithm on them, because there are as many as seeds. They cover what the four fixed sites do not: floors with the same
//! partition above each other, offices furnished alike, ring corridors, and windows of glass. The same seed gives the same building, bit for bit.
//!
//! - `layout`: corridors, rooms, doors and stairs as a plan;
//! - `walk`: routes and pedestrian paths through the plan;
//! - `shell`: floors, walls, windows, stairs and roof;
//! - `furniture`: what stands in the rooms, where it leaves the routes free.

mod choice;
mod furniture;
mod layout;
mod shell;
mod walk;

use super::parts::Builder;
use super::plan::SitePlan;
use geometry::RngTree;
use walk::Walks;

pub(crate) use layout::BuildingLayout;
#[cfg(test)]
pub(crate) use layout::Room;

/// Estimated duration of a round that a building may have, seconds. A walk of ten minutes then sees all of it.
const MAX_ROUND_S: f64 = 570.0;
/// Largest number of layouts that are drawn for a building.
const MAX_DRAWS: usize = 64;

/// The building of that seed.
pub(super) fn plan(seed: u64) -> SitePlan {
    let tree = tree(seed);
    let (layout, walks) = draw(&tree);
    let mut b = Builder { plan: SitePlan::default(), rng: tree.child("shell").rng() };
    shell::build(&mut b, &layout);
    for (position, yaw) in &walks.docks {
        b.dock(*position, *yaw);
    }
    furniture::furnish(&mut b, &layout, &walks, &tree.child("furniture"));
    b.plan.outline =
        vec![[0.0, 0.0], [layout.length, 0.0], [layout.length, layout.width], [0.0, layout.width]];
    b.plan.routes = walks.routes;
    b.plan.pedestrian_paths = walks.pedestrian_paths;
    b.plan
}

/// Draws layouts until the round of one is short enough.
fn draw(tree: &RngTree) -> (BuildingLayout, Walks) {
    let mut rng = tree.child("layout").rng();
    let mut next = || {
        let layout = layout::draw(&mut rng);
        let walks = walk::walks(&layout, &mut rng);
        (layout, walks)
    };
    let mut drawn = next();
    for _ in 1..MAX_DRAWS {
        if walk::duration_s(&drawn.1.round) <= MAX_ROUND_S {
            break;
        }
        drawn = next();
    }
    drawn
}

/// The layout of the building of that seed.
#[cfg(test)]
pub(crate) fn layout(seed: u64) -> BuildingLayout {
    draw(&tree(seed)).0
}

fn tree(seed: u64) -> RngTree {
    RngTree::new(seed).child("generated site")
}
