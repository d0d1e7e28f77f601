//! Design tokens: every colour, size and distance of the client is named here and nowhere else.

use client_model::Theme;
use egui::{Color32, CornerRadius, FontData, FontDefinitions, FontFamily, FontId, Margin, Stroke, Visuals};
use std::sync::Arc;

/// Space between cards and around them, points.
pub const GAP: f32 = 12.0;
/// Space inside a card, points.
pub const PADDING: i8 = 12;
/// Corner radius of cards.
pub const CARD_RADIUS: u8 = 12;
/// Corner radius of buttons and rows.
pub const BUTTON_RADIUS: u8 = 8;
/// Least side of anything that can be touched, points.
pub const TOUCH: f32 = 44.0;
/// Height of the top bar, points.
pub const TOP_BAR: f32 = 48.0;
/// Width of the rail, points.
pub const RAIL: f32 = 64.0;
/// Width of the right card, points.
pub const CARD_WIDTH: f32 = 344.0;
/// Width of a card beside the tools, points.
pub const LEFT_CARD_WIDTH: f32 = 284.0;
/// Small texts.
pub const SMALL: f32 = 12.0;
/// Texts.
pub const BODY: f32 = 14.0;
/// Texts of buttons and heads of cards.
pub const HEAD: f32 = 15.0;
/// Large figures.
pub const LARGE: f32 = 20.0;
/// Icons beside text.
pub const ICON: f32 = 18.0;

/// Colours of one theme. The fields are the names of the design.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs, reason = "the design's own names; its meanings are given where they need words")]
pub struct Tokens {
    pub ground: Color32,
    pub card: Color32,
    pub raised: Color32,
    pub line: Color32,
    pub text: Color32,
    pub dim: Color32,
    /// Selection, navigating, the path to the next task.
    pub accent: Color32,
    /// Behind the text of primary buttons.
    pub accent_filled: Color32,
    /// Text on `accent_filled` and on `stop`.
    pub on_filled: Color32,
    /// Done, healthy.
    pub good: Color32,
    /// Skipped, later, attention.
    pub warn: Color32,
    /// Failed, lost.
    pub bad: Color32,
    /// The stop button and nothing else.
    pub stop: Color32,
    pub robot: Color32,
    /// Loops that are edges of the graph.
    pub closed: Color32,
    /// The older of two scans that are compared.
    pub older: Color32,
    /// The newer one.
    pub newer: Color32,
    /// Width of borders, points.
    pub line_width: f32,
    /// Whether the theme is dark.
    pub dark: bool,
}

const fn rgb(hex: u32) -> Color32 {
    Color32::from_rgb((hex >> 16) as u8, (hex >> 8) as u8, hex as u8)
}

const DARK: Tokens = Tokens {
    ground: rgb(0x0d_1117),
    // 121821 at 92 %, premultiplied.
    card: Color32::from_rgba_premultiplied(17, 22, 30, 235),
    raised: rgb(0x1a_222e),
    line: rgb(0x26_3040),
    text: rgb(0xe6_edf3),
    dim: rgb(0x8b_98a6),
    accent: rgb(0x58_a6ff),
    accent_filled: rgb(0x1f_6feb),
    on_filled: Color32::WHITE,
    good: rgb(0x3f_b950),
    warn: rgb(0xd2_9922),
    bad: rgb(0xf8_5149),
    stop: rgb(0xc9_371f),
    robot: rgb(0xff_d33d),
    closed: rgb(0xc2_97ff),
    older: rgb(0x39_d0d8),
    newer: rgb(0xff_8c42),
    line_width: 1.0,
    dark: true,
};

/// Indoors by day: every text and sign at 4.5:1 or better against what is behind it, boxes in the colour of a state included.
const LIGHT: Tokens = Tokens {
    ground: rgb(0xf4_f6f9),
    card: Color32::WHITE,
    raised: rgb(0xee_f2f7),
    line: rgb(0xd8_dfe8),
    text: rgb(0x17_202b),
    dim: rgb(0x5a_6778),
    accent: rgb(0x17_5cc4),
    accent_filled: rgb(0x1f_6feb),
    on_filled: Color32::WHITE,
    good: rgb(0x1a_7635),
    warn: rgb(0x8f_5f00),
    bad: rgb(0xc6_1e2a),
    stop: rgb(0xc9_371f),
    robot: rgb(0xd4_a300),
    closed: rgb(0x82_50df),
    older: rgb(0x00_7c89),
    newer: rgb(0xc9_4f00),
    line_width: 1.0,
    dark: false,
};

/// Outdoors: every text and sign at 10:1 or better against what is behind it.
const SUNLIGHT: Tokens = Tokens {
    ground: rgb(0xff_ffff),
    card: rgb(0xff_ffff),
    raised: rgb(0xf2_f4f7),
    line: rgb(0x00_0000),
    text: rgb(0x00_0000),
    dim: rgb(0x26_2e38),
    accent: rgb(0x00_2e73),
    accent_filled: rgb(0x00_2e73),
    on_filled: Color32::WHITE,
    good: rgb(0x00_3d12),
    warn: rgb(0x4a_2c00),
    bad: rgb(0x6b_000a),
    stop: rgb(0xc9_371f),
    robot: rgb(0x7a_4f00),
    closed: rgb(0x4c_1d95),
    older: rgb(0x00_3f47),
    newer: rgb(0x6a_2000),
    line_width: 2.0,
    dark: false,
};

impl Tokens {
    /// The colours of a theme.
    pub fn of(theme: Theme) -> Self {
        match theme {
            Theme::Dark => DARK,
            Theme::Light => LIGHT,
            Theme::Sunlight => SUNLIGHT,
        }
    }

    /// The border of cards and buttons.
    pub fn border(&self) -> Stroke {
        Stroke::new(self.line_width, self.line)
    }

    /// Lines and areas behind content: grids, and what is left of a bar. Borders are stronger outdoors.
    pub fn faint(&self) -> Color32 {
        let card = self.card.to_opaque();
        if self.line_width > 1.0 { mix(card, self.text, 0.25) } else { mix(card, self.line, 0.8) }
    }

    /// Background of a selected row or rail entry: the card's colour with a little of the accent.
    pub fn selected(&self) -> Color32 {
        mix(self.card.to_opaque(), self.accent_filled, if self.dark { 0.28 } else { 0.08 })
    }

    /// Background of a box that carries a state's colour.
    pub fn tinted(&self, colour: Color32) -> Color32 {
        mix(self.card.to_opaque(), colour, if self.dark { 0.12 } else { 0.08 })
    }

    /// A button's background while the pointer is over it.
    pub fn hovered(&self, fill: Color32) -> Color32 {
        mix(fill, self.text, 0.08)
    }
}

/// `share` (0..1) of `b` in `a`, in gamma space as designers mix.
pub fn mix(a: Color32, b: Color32, share: f32) -> Color32 {
    let channel = |a: u8, b: u8| (f32::from(a) + (f32::from(b) - f32::from(a)) * share).round() as u8;
    Color32::from_rgba_premultiplied(
        channel(a.r(), b.r()),
        channel(a.g(), b.g()),
        channel(a.b(), b.b()),
        channel(a.a(), b.a()),
    )
}

/// Weights of the one family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the usual names of weights")]
pub enum Weight {
    Regular,
    Medium,
    SemiBold,
}

/// The font for a size in points and a weight.
pub fn font(size: f32, weight: Weight) -> FontId {
    let family = match weight {
        Weight::Regular => FontFamily::Proportional,
        Weight::Medium => FontFamily::Name("medium".into()),
        Weight::SemiBold => FontFamily::Name("semibold".into()),
    };
    FontId::new(size, family)
}

/// The file of the family's regular weight.
pub const INTER_REGULAR: &[u8] = include_bytes!("../fonts/Inter-Regular.ttf");

/// Installs fonts; once.
pub fn install_fonts(ctx: &egui::Context) {
    const FILES: [(&str, &[u8]); 4] = [
        ("Inter-Regular", INTER_REGULAR),
        ("Inter-Medium", include_bytes!("../fonts/Inter-Medium.ttf")),
        ("Inter-SemiBold", include_bytes!("../fonts/Inter-SemiBold.ttf")),
        ("Phosphor", include_bytes!("../fonts/Phosphor.ttf")),
    ];
    let mut fonts = FontDefinitions::empty();
    for (name, bytes) in FILES {
        fonts.font_data.insert(name.to_owned(), Arc::new(FontData::from_static(bytes)));
    }
    let chain = |first: &str| vec![first.to_owned(), "Inter-Regular".to_owned(), "Phosphor".to_owned()];
    fonts.families.insert(FontFamily::Proportional, chain("Inter-Regular"));
    fonts.families.insert(FontFamily::Monospace, chain("Inter-Regular"));
    fonts.families.insert(FontFamily::Name("medium".into()), chain("Inter-Medium"));
    fonts.families.insert(FontFamily::Name("semibold".into()), chain("Inter-SemiBold"));
    ctx.set_fonts(fonts);
}

/// Makes egui's own widgets look like the theme.
pub fn install(ctx: &egui::Context, theme: Theme) {
    let tokens = Tokens::of(theme);
    let egui_theme = if tokens.dark { egui::Theme::Dark } else { egui::Theme::Light };
    ctx.set_theme(egui_theme);
    ctx.set_visuals_of(egui_theme, visuals(&tokens));
    // A press of any length is a click. Long presses mean nothing here, egui counts a press from frame to frame, and on a slow tablet a frame may be longer than egui's limit.
    ctx.options_mut(|options| options.input_options.max_click_duration = f64::INFINITY);
    ctx.all_styles_mut(|style| {
        style.spacing.item_spacing = egui::vec2(8.0, 8.0);
        style.spacing.interact_size = egui::vec2(TOUCH, 32.0);
        style.spacing.button_padding = egui::vec2(12.0, 8.0);
        style.spacing.slider_width = 140.0;
        style.spacing.slider_rail_height = 6.0;
        style.spacing.scroll.floating = true;
        // Room for the bar, so that it never lies over figures at the right edge.
        style.spacing.scroll.floating_allocated_width = 8.0;
        style.interaction.selectable_labels = false;
        style.interaction.tooltip_delay = 0.4;
        style.text_styles = [
            (egui::TextStyle::Small, font(SMALL, Weight::Regular)),
            (egui::TextStyle::Body, font(BODY, Weight::Regular)),
            (egui::TextStyle::Button, font(BODY, Weight::Medium)),
            (egui::TextStyle::Monospace, font(BODY, Weight::Regular)),
            (egui::TextStyle::Heading, font(HEAD, Weight::SemiBold)),
        ]
        .into();
    });
}

fn visuals(tokens: &Tokens) -> Visuals {
    let mut visuals = if tokens.dark { Visuals::dark() } else { Visuals::light() };
    let radius = CornerRadius::same(BUTTON_RADIUS);
    for (widget, fill, text) in [
        (&mut visuals.widgets.noninteractive, tokens.card, tokens.text),
        (&mut visuals.widgets.inactive, tokens.raised, tokens.text),
        (&mut visuals.widgets.hovered, tokens.hovered(tokens.raised), tokens.text),
        (&mut visuals.widgets.active, tokens.selected(), tokens.text),
        (&mut visuals.widgets.open, tokens.raised, tokens.text),
    ] {
        widget.bg_fill = fill;
        widget.weak_bg_fill = fill;
        widget.bg_stroke = tokens.border();
        widget.fg_stroke = Stroke::new(tokens.line_width, text);
        widget.corner_radius = radius;
        widget.expansion = 0.0;
    }
    visuals.override_text_color = None;
    visuals.weak_text_color = Some(tokens.dim);
    visuals.panel_fill = tokens.ground;
    visuals.window_fill = tokens.card;
    visuals.window_stroke = tokens.border();
    visuals.window_shadow = egui::Shadow::NONE;
    visuals.popup_shadow = egui::Shadow::NONE;
    visuals.window_corner_radius = CornerRadius::same(CARD_RADIUS);
    visuals.menu_corner_radius = CornerRadius::same(BUTTON_RADIUS);
    visuals.extreme_bg_color = tokens.ground;
    visuals.selection.bg_fill = tokens.accent_filled;
    visuals.selection.stroke = Stroke::new(1.0, tokens.on_filled);
    visuals.slider_trailing_fill = true;
    visuals.hyperlink_color = tokens.accent;
    visuals
}

/// The frame of a card.
pub fn card(tokens: &Tokens) -> egui::Frame {
    egui::Frame::new()
        .fill(tokens.card)
        .stroke(tokens.border())
        .corner_radius(CornerRadius::same(CARD_RADIUS))
        .inner_margin(Margin::same(PADDING))
}

/// The shadow of what is dragged. Nothing else has one.
pub fn drag_shadow(tokens: &Tokens) -> egui::Shadow {
    let alpha = if tokens.dark { 150 } else { 70 };
    egui::Shadow { offset: [0, 4], blur: 16, spread: 0, color: Color32::from_black_alpha(alpha) }
}

#[cfg(test)]
mod tests;
