//! Colour maps of heights, intensities and ages.

/// Evenly spaced colours that the shader interpolates between.
pub(crate) const STOPS: usize = 12;

/// Maps a value between 0 and 1 to a colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColourMap {
    /// Slate, teal, sand. Muted, so that the overlay stands out.
    #[default]
    Muted,
    /// The same hues for a light ground: the floor is nearly as light as the ground, so that lines and nodes on it stand out.
    MutedLight,
    /// Google's Turbo: distinguishes the most values.
    Turbo,
    /// Matplotlib's viridis: readable for the colour-blind and in print.
    Viridis,
    /// Black to white.
    Grey,
}

impl ColourMap {
    /// Colour of `value`, clamped to 0..=1; gamma-encoded red, green, blue between 0 and 1.
    pub fn colour(self, value: f32) -> [f32; 3] {
        let table = self.table();
        let position = value.clamp(0.0, 1.0) * (table.len() - 1) as f32;
        let below = (position as usize).min(table.len() - 2);
        let fraction = position - below as f32;
        std::array::from_fn(|i| {
            let (a, b) = (f32::from(table[below][i]), f32::from(table[below + 1][i]));
            (a + (b - a) * fraction) / 255.0
        })
    }

    /// Evenly spaced colours for the shader.
    pub(crate) fn stops(self) -> [[f32; 4]; STOPS] {
        std::array::from_fn(|i| {
            let [r, g, b] = self.colour(i as f32 / (STOPS - 1) as f32);
            [r, g, b, 1.0]
        })
    }

    fn table(self) -> &'static [[u8; 3]] {
        match self {
            Self::Muted => &[
                [44, 62, 88],
                [48, 76, 104],
                [50, 94, 116],
                [54, 113, 124],
                [74, 134, 132],
                [112, 156, 138],
                [158, 176, 146],
                [196, 190, 156],
                [218, 204, 170],
            ],
            Self::MutedLight => &[
                [198, 207, 219],
                [178, 196, 210],
                [152, 184, 196],
                [126, 170, 178],
                [106, 156, 158],
                [114, 148, 136],
                [140, 148, 120],
                [162, 150, 112],
                [174, 146, 98],
            ],
            Self::Turbo => &[
                [48, 18, 59],
                [70, 98, 215],
                [54, 170, 249],
                [26, 228, 182],
                [114, 254, 94],
                [200, 239, 52],
                [250, 186, 57],
                [246, 107, 25],
                [203, 42, 4],
                [122, 4, 3],
            ],
            Self::Viridis => &[
                [68, 1, 84],
                [72, 40, 120],
                [62, 74, 137],
                [49, 104, 142],
                [38, 130, 142],
                [31, 158, 137],
                [53, 183, 121],
                [109, 205, 89],
                [180, 222, 44],
                [253, 231, 37],
            ],
            Self::Grey => &[[24, 26, 30], [240, 242, 245]],
        }
    }
}
