//! How changes of the scene are shown in 3D: the objects of the earlier visit, those of the later one, or both, and where one gives way to the other.

mod shown;

use super::Feature;
use crate::ClientCommand;
use crate::shared::Context;
pub use shown::ShownChanges;

/// How changes are shown.
#[derive(Clone, Copy, Debug, Default)]
pub struct ChangesView {
    shown: ShownChanges,
}

impl ChangesView {
    /// Whose objects are shown.
    pub fn shown(&self) -> ShownChanges {
        self.shown
    }
}

impl Feature for ChangesView {
    fn on_command(&mut self, command: &ClientCommand, _cx: &mut Context<'_>) {
        if let ClientCommand::ShowChanges(shown) = command {
            self.shown = match *shown {
                ShownChanges::Wipe(share) => ShownChanges::Wipe(share.clamp(0.0, 1.0)),
                shown => shown,
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::TestClient;

    #[test]
    fn one_visit_both_or_a_wipe_between_them_is_shown() {
        let mut client = TestClient::connected();
        assert_eq!(client.model.changes_view.shown().visits(), [true, true]);
        for (shown, visits, wipe) in [
            (ShownChanges::Before, [true, false], None),
            (ShownChanges::After, [false, true], None),
            (ShownChanges::Wipe(1.5), [true, true], Some(1.0)),
        ] {
            client.command(ClientCommand::ShowChanges(shown));
            let shown = client.model.changes_view.shown();
            assert_eq!((shown.visits(), shown.wipe()), (visits, wipe));
        }
    }
}
