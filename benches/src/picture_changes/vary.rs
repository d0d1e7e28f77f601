//! Other values of the parameters, to see how sensitive the results are.

use anyhow::{Context, Result, bail};
use picture_changes::{PictureAlignmentConfig, PictureChangesConfig};

/// The parameters of the alignment and of the search for changes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Parameters {
    pub alignment: PictureAlignmentConfig,
    pub changes: PictureChangesConfig,
}

impl Parameters {
    /// The defaults with these other values, each as NAME=VALUE.
    ///
    /// # Errors
    /// When a name is not known or a value is no number.
    pub fn varied(values: &[String]) -> Result<Self> {
        let mut parameters = Self::default();
        for value in values {
            let (name, number) =
                value.split_once('=').with_context(|| format!("'{value}' is not NAME=VALUE"))?;
            let number: f64 = number.parse().with_context(|| format!("'{value}' has no number"))?;
            parameters.set(name, number)?;
        }
        Ok(parameters)
    }

    fn set(&mut self, name: &str, number: f64) -> Result<()> {
        let Self { alignment, changes } = self;
        let field = match name {
            "min_contrast" => &mut alignment.min_contrast,
            "min_gradient" => &mut alignment.min_gradient,
            "weight_radius_share" => &mut alignment.weight_radius_share,
            "max_deviation_px" => &mut alignment.max_deviation_px,
            "min_block_correlation" => &mut alignment.min_block_correlation,
            "min_correlation" => &mut alignment.min_correlation,
            "dark_light" => &mut changes.dark_light,
            "min_noise" => &mut changes.min_noise,
            "noise_tolerance" => &mut changes.noise_tolerance,
            "displacement_tolerance_px" => &mut changes.displacement_tolerance_px,
            "plane_share" => &mut changes.plane_share,
            "displaced_share" => &mut changes.displaced_share,
            "off_plane_share" => &mut changes.off_plane_share,
            "overexposed_range" => &mut changes.overexposed_range,
            "min_colour_change" => &mut changes.min_colour_change,
            "min_total_strength" => &mut changes.min_total_strength,
            "max_light_change" => &mut changes.max_light_change,
            "min_area_px" => {
                changes.min_area_px = number as usize;
                return Ok(());
            }
            _ => bail!("'{name}' is no parameter that can be varied"),
        };
        *field = number;
        Ok(())
    }
}
