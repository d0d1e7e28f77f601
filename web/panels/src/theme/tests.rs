//! Contrast of the colours.

use crate::test_support::contrast;
use crate::theme;
use client_model::Theme;

#[test]
fn texts_stand_out_in_every_theme() {
    for name in Theme::ALL {
        let tokens = theme::Tokens::of(name);
        let (card, least) = (tokens.card.to_opaque(), if name == Theme::Sunlight { 10.0 } else { 4.5 });
        for colour in [tokens.text, tokens.dim] {
            assert!(contrast(colour, card) >= least, "{name:?}: {colour:?} on {card:?}");
        }
        if name == Theme::Sunlight {
            for colour in [tokens.accent, tokens.good, tokens.warn, tokens.bad] {
                assert!(contrast(colour, card) >= least, "{name:?}: {colour:?} on {card:?}");
            }
        }
    }
}
