//! Changes of a zone: each a step of undo.

use crate::feature_panel::PanelContext;
use client_model::{ClientCommand, SiteEdit};
use site_model::Zone;

/// Changes a zone, unless that leaves it as it is.
pub(super) fn change(cx: &mut PanelContext<'_>, zone: &Zone, change: impl FnOnce(&mut Zone)) {
    let edit = cx.model.site.changing_zone(zone.id, change);
    if edit != SiteEdit::default() {
        cx.commands.push(ClientCommand::EditSite(edit));
    }
}
