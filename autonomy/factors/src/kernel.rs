//! Robust kernels: they limit the cost of a large residual.
//!
//! With the squared whitened residual `s`, a factor costs `ρ(s)` (docs/maths/factors.md, equations 3 and 11 to 14). Its normal equations are
//! weighted by `ρ'(s)` (iteratively re-weighted least squares). Every kernel equals `s` near zero.
//! Sources: Zhang, *Parameter estimation techniques*, 1997; Agarwal and others, *Robust map optimization using dynamic
//! covariance scaling*, ICRA 2013.

/// A robust kernel. Its parameter is in standard deviations unless stated otherwise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Kernel {
    /// Least squares.
    #[default]
    None,
    /// Linear beyond `k`.
    Huber(f64),
    /// `k² ln(1 + s / k²)`.
    Cauchy(f64),
    /// `s / (1 + s / k²)`, which is bounded by `k²`.
    GemanMcClure(f64),
    /// Dynamic covariance scaling with the parameter `φ`, in squared standard deviations: least squares up to `s = φ`, then
    /// bounded by `3 φ`.
    DynamicCovarianceScaling(f64),
}

impl Kernel {
    /// `(ρ(s), ρ'(s))` of a squared whitened residual.
    pub fn evaluate(self, squared: f64) -> (f64, f64) {
        match self {
            Self::None => (squared, 1.0),
            Self::Huber(k) => {
                if squared <= k * k {
                    (squared, 1.0)
                } else {
                    let length = squared.sqrt();
                    (k * (2.0 * length - k), k / length)
                }
            }
            Self::Cauchy(k) => {
                let ratio = squared / (k * k);
                (k * k * ratio.ln_1p(), 1.0 / (1.0 + ratio))
            }
            Self::GemanMcClure(k) => {
                let share = 1.0 / (1.0 + squared / (k * k));
                (squared * share, share * share)
            }
            Self::DynamicCovarianceScaling(phi) => {
                if squared <= phi {
                    (squared, 1.0)
                } else {
                    // The slope is the square of the residual's scale 2φ / (φ + s). The cost is the slope's integral.
                    let scale = 2.0 * phi / (phi + squared);
                    (phi * (3.0 * squared - phi) / (phi + squared), scale * scale)
                }
            }
        }
    }

    /// Whether the parameter is a positive number.
    pub fn is_valid(self) -> bool {
        match self {
            Self::None => true,
            Self::Huber(k) | Self::Cauchy(k) | Self::GemanMcClure(k) | Self::DynamicCovarianceScaling(k) => {
                k.is_finite() && k > 0.0
            }
        }
    }
}
