//! Contrast of the colours.

use crate::test_support::contrast;
use crate::theme;
use client_model::Theme;

#[test]
fn texts_stand_out_in_every_theme() {
    for name in Theme::ALL {
        let tokens = theme::Tokens::of(name);
        let (card, least) = (tokens.card.to_opaque(), if name == Theme::Sunlight { 10.0 } else { 4.5 });
        let states = [tokens.accent, tokens.good, tokens.warn, tokens.bad];
        let stands_out = |colour, behind| {
            let found = contrast(colour, behind);
            assert!(found >= least, "{name:?}: {colour:?} on {behind:?}: {found:.2}");
        };
        for colour in [tokens.text, tokens.dim].into_iter().chain(states) {
            stands_out(colour, card);
            stands_out(colour, tokens.raised);
        }
        for state in states {
            for colour in [tokens.text, tokens.dim] {
                stands_out(colour, tokens.tinted(state));
            }
        }
        stands_out(tokens.accent, tokens.selected());
    }
}
