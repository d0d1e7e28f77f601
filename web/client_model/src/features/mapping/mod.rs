//! The mapping session: start, extend, finish, discard.

use super::Feature;
use crate::ClientCommand;
use crate::shared::{Context, SliceChange};
use api::Mapping;

/// The mapping session as the robot last reported it.
#[derive(Clone, Debug, Default)]
pub struct MappingFeature {
    mapping: Mapping,
}

impl MappingFeature {
    pub(crate) fn state(&self) -> &Mapping {
        &self.mapping
    }

    fn update(&mut self, mapping: &Mapping, cx: &mut Context<'_>) {
        let before = std::mem::replace(&mut self.mapping, mapping.clone());
        if let (Mapping::Saving { map }, Mapping::Idle) = (&before, mapping) {
            // The operator wants to see the map that was just saved.
            cx.view_map(Some(*map));
        }
        let begun = !matches!(mapping, Mapping::Idle | Mapping::Saving { .. });
        if before == Mapping::Idle && begun {
            cx.view_map(None);
        }
        let same_phase = std::mem::discriminant(&before) == std::mem::discriminant(mapping);
        if let (
            Mapping::Loading { .. } | Mapping::Starting { .. } | Mapping::Finding { .. },
            Mapping::Finding { .. } | Mapping::Running { .. },
        ) = (&before, mapping)
            && !same_phase
        {
            cx.changes.push(SliceChange::FrameChanged);
        }
    }
}

impl Feature for MappingFeature {
    fn on_event(&mut self, event: &api::Event, cx: &mut Context<'_>) {
        if let api::Event::Mapping(mapping) = event {
            self.update(mapping, cx);
        }
    }

    fn on_command(&mut self, command: &ClientCommand, cx: &mut Context<'_>) {
        match command {
            ClientCommand::StartMapping => {
                let session = cx.shared.ids.session();
                cx.send_in_control(api::Command::StartMapping(session));
            }
            ClientCommand::ExtendMap(map) => {
                let session = cx.shared.ids.session();
                cx.send_in_control(api::Command::ExtendMap { session, map: *map });
            }
            ClientCommand::FinishMapping { name } => {
                let map = cx.shared.ids.map();
                let name = name.trim().to_owned();
                cx.send_in_control(api::Command::FinishMapping { map, name });
            }
            ClientCommand::DiscardMapping => cx.send_in_control(api::Command::DiscardMapping),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests;
