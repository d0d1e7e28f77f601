//! What closes edges for a time: blocks that the robot has made, and groups of edges that somebody holds. Each edit is a step of undo.

use super::{SiteEdit, SiteFeature};
use missions::is_blocked;
use site_model::{EdgeBlock, MutexHold, MutexHoldId, Object, ObjectId};
use std::collections::BTreeSet;
use vocab::Stamp;

impl SiteFeature {
    /// The blocks that hold now, the first to end first. `now`: on the robot's clock; none: every block counts.
    pub fn blocks_now(&self, now: Option<Stamp>) -> Vec<&EdgeBlock> {
        let blocks = self.site().into_iter().flat_map(|site| site.edge_blocks());
        let mut blocks: Vec<_> =
            blocks.filter(|block| now.is_none_or(|now| is_blocked(block, now))).collect();
        blocks.sort_by(|a, b| a.until.cmp(&b.until).then(a.edge.cmp(&b.edge)));
        blocks
    }

    /// A site without the block of an edge, and without that of the edge that leads back: the robot blocks both when it cannot pass.
    pub fn unblocking(&self, block: &EdgeBlock) -> SiteEdit {
        let mut removed = vec![ObjectId::EdgeBlock(block.edge)];
        if let Some(site) = self.site()
            && let Some(edge) = site.edge(block.edge)
        {
            let back = site.edges().filter(|it| (it.from, it.to) == (edge.to, edge.from));
            let blocked = back.map(|it| ObjectId::EdgeBlock(it.id)).filter(|id| site.get(*id).is_some());
            removed.extend(blocked);
        }
        SiteEdit { put: Vec::new(), removed }
    }

    /// The groups of edges that somebody holds, by name.
    pub fn mutex_holds(&self) -> Vec<&MutexHold> {
        let mut holds: Vec<_> = self.site().into_iter().flat_map(|site| site.mutex_holds()).collect();
        holds.sort_by(|a, b| a.group.cmp(&b.group).then(a.id.cmp(&b.id)));
        holds
    }

    /// A group of edges is held for a person from now on.
    pub fn holding_group(&self, group: &str, holder: &str) -> SiteEdit {
        let (id, group, holder) = (MutexHoldId(self.new_id(0)), group.to_owned(), holder.to_owned());
        SiteEdit { put: vec![Object::MutexHold(MutexHold { id, group, holder })], removed: Vec::new() }
    }

    /// Nobody holds a group of edges any more.
    pub fn releasing_group(&self, group: &str) -> SiteEdit {
        let of_group: BTreeSet<ObjectId> = self
            .mutex_holds()
            .into_iter()
            .filter(|hold| hold.group == group)
            .map(|hold| ObjectId::MutexHold(hold.id))
            .collect();
        SiteEdit { put: Vec::new(), removed: of_group.into_iter().collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::Robot;
    use crate::testing::TestClient;
    use crate::{ClientCommand, SiteEdit};
    use site_model::{EdgeBlock, Object};
    use vocab::{MapId, Stamp, Vec3};

    #[test]
    fn blocks_of_both_directions_are_lifted_in_one_step_and_a_group_is_held_and_released() {
        let robot = Robot::default();
        let mut client = TestClient::with_site(&robot);
        let mut last = None;
        for x in [0.0, 3.0] {
            let map = MapId(uuid::Uuid::from_u128(3));
            let (node, edit) = client.model.site.adding_node(Vec3::new(x, 0.0, 0.5), map, last);
            client.command(ClientCommand::EditSite(edit));
            last = Some(node);
        }
        let at = Stamp::from_secs_f64;
        let edges: Vec<_> = client.model.site.site().unwrap().edges().map(|edge| edge.id).collect();
        let put = edges.iter().map(|edge| {
            let reason = "The path is blocked.".to_owned();
            Object::EdgeBlock(EdgeBlock { edge: *edge, until: at(60.0), failures: 1, reason })
        });
        client.command(ClientCommand::EditSite(SiteEdit { put: put.collect(), removed: Vec::new() }));
        assert_eq!(client.model.site.blocks_now(Some(at(59.0))).len(), 2);
        assert!(client.model.site.blocks_now(Some(at(60.0))).is_empty(), "their time is over");

        let block = client.model.site.blocks_now(None)[0].clone();
        client.command(ClientCommand::EditSite(client.model.site.unblocking(&block)));
        assert!(client.model.site.blocks_now(None).is_empty());
        client.command(ClientCommand::Undo);
        assert_eq!(client.model.site.blocks_now(None).len(), 2);

        client.command(ClientCommand::EditSite(client.model.site.holding_group("Corridor", "Ada")));
        assert_eq!(client.model.site.mutex_holds()[0].holder, "Ada");
        client.command(ClientCommand::EditSite(client.model.site.releasing_group("Corridor")));
        assert!(client.model.site.mutex_holds().is_empty());
    }
}
