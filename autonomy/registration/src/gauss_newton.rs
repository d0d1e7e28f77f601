//! The Gauss-Newton iteration that scan registrations share: wide matching first, then narrower, until the step is short.

use crate::linearise::MatchingConfig;
use geometry::{Matrix6, Vector6};

/// How the matching narrows from its initial width to 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WidthSchedule {
    /// By the same amount in every iteration, so that the last possible iteration has width 1. The iteration may converge at any
    /// width.
    Linear,
    /// By half in every iteration. The iteration converges at width 1 only.
    Halving,
}

/// Parameters of [`gauss_newton`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussNewtonConfig {
    /// Greatest number of iterations. Chosen: it bounds the time; registrations that begin near end sooner.
    pub max_iterations: usize,
    /// A step shorter than this (norm of radians and metres) ends the iteration. Chosen: a hundredth of a millimetre, far below the noise.
    pub min_step: f64,
    /// Factor on gate and kernel width of the matching in the first iteration, at least 1. Chosen: 0.5 m at the default gate.
    pub initial_width: f32,
    /// How the factor goes down to 1. Chosen: it needs no further value.
    pub schedule: WidthSchedule,
    /// Damping added to the diagonal of the information, as a share of its trace. It keeps directions without information where they
    /// are. Chosen: far below the information of any direction that is observed.
    pub relative_damping: f64,
    /// Damping added to the diagonal of the information, in its own units, for an information of zero. Chosen: it only has to be above zero.
    pub absolute_damping: f64,
}

impl Default for GaussNewtonConfig {
    fn default() -> Self {
        Self {
            max_iterations: 10,
            min_step: 1e-5,
            initial_width: 5.0,
            schedule: WidthSchedule::Linear,
            relative_damping: 1e-6,
            absolute_damping: 1e-9,
        }
    }
}

impl GaussNewtonConfig {
    /// The damping of an information matrix: what is added to its diagonal.
    pub fn damping(&self, information: &Matrix6) -> f64 {
        information.trace() * self.relative_damping + self.absolute_damping
    }

    /// The step `-(H + damping)⁻¹ g` that minimises the damped quadratic cost (docs/maths/odometry.md, equation 16). `None` if the
    /// damped information is not positive definite, or if the step is not finite.
    pub fn solve(&self, information: &Matrix6, gradient: &Vector6) -> Option<Vector6> {
        Self::solve_damped(information, gradient, self.damping(information))
    }

    /// As [`Self::solve`], with a damping that is given. Equations that were projected onto the observed directions are damped by the
    /// information before the projection.
    pub fn solve_damped(information: &Matrix6, gradient: &Vector6, damping: f64) -> Option<Vector6> {
        let factor = (information + Matrix6::identity() * damping).cholesky()?;
        Some(factor.solve(&-gradient)).filter(|step| step.iter().all(|component| component.is_finite()))
    }

    /// Factor on gate and kernel width in an iteration, counted from 0.
    fn width(&self, iteration: usize) -> f32 {
        match self.schedule {
            WidthSchedule::Linear => {
                let progress = (iteration + 1) as f32 / self.max_iterations as f32;
                1.0 + (self.initial_width - 1.0) * (1.0 - progress)
            }
            WidthSchedule::Halving => {
                (0..iteration).fold(self.initial_width, |width, _| (width * 0.5).max(1.0))
            }
        }
    }
}

/// Iterates from `start`. `step` computes the next state and the length of the step to it (norm of radians and metres) from the
/// present state and the widened matching; `None` ends the iteration.
pub fn gauss_newton<State>(
    start: State,
    matching: &MatchingConfig,
    config: &GaussNewtonConfig,
    mut step: impl FnMut(&State, &MatchingConfig) -> Option<(State, f64)>,
) -> State {
    let mut state = start;
    for iteration in 0..config.max_iterations {
        let width = config.width(iteration);
        let Some((next, length)) = step(&state, &matching.widened(width)) else { break };
        state = next;
        let may_converge = config.schedule == WidthSchedule::Linear || width <= 1.0;
        if may_converge && length < config.min_step {
            break;
        }
    }
    state
}

#[cfg(test)]
mod tests {
    use super::*;

    fn widths(config: &GaussNewtonConfig, length: f64) -> Vec<f32> {
        let mut widths = Vec::new();
        gauss_newton(
            (),
            &MatchingConfig { gate_m: 1.0, ..MatchingConfig::default() },
            config,
            |(), matching| {
                widths.push(matching.gate_m);
                Some(((), length))
            },
        );
        widths
    }

    #[test]
    fn the_width_goes_down_to_one() {
        let linear =
            GaussNewtonConfig { max_iterations: 4, initial_width: 5.0, ..GaussNewtonConfig::default() };
        assert_eq!(widths(&linear, 1.0), [4.0, 3.0, 2.0, 1.0]);
        let halving = GaussNewtonConfig { schedule: WidthSchedule::Halving, initial_width: 3.0, ..linear };
        assert_eq!(widths(&halving, 1.0), [3.0, 1.5, 1.0, 1.0]);
    }

    #[test]
    fn there_is_no_step_without_information_or_with_a_gradient_that_is_not_finite() {
        let config = GaussNewtonConfig::default();
        let (information, gradient) = (Matrix6::identity() * 2.0, Vector6::repeat(4.0));
        let Some(step) = config.solve(&information, &gradient) else { panic!("no step") };
        assert!((step + Vector6::repeat(2.0)).norm() < 1e-4, "{step}");
        assert_eq!(config.solve(&-information, &gradient), None);
        assert_eq!(config.solve(&information, &Vector6::repeat(f64::INFINITY)), None);
        assert_eq!(config.solve(&information, &Vector6::repeat(f64::NAN)), None);
    }

    #[test]
    fn a_given_damping_keeps_directions_without_information_where_they_are() {
        let mut information = Matrix6::identity() * 3.0;
        information[(5, 5)] = 0.0;
        let gradient = Vector6::new(3.0, 3.0, 3.0, 3.0, 3.0, 0.0);
        let Some(step) = GaussNewtonConfig::solve_damped(&information, &gradient, 1e-9) else {
            panic!("no step")
        };
        assert!((step.rows(0, 5) + nalgebra::Vector5::repeat(1.0)).norm() < 1e-8, "{step}");
        assert_eq!(step[5], 0.0);
    }

    #[test]
    fn a_short_step_ends_a_linear_schedule_at_once_and_a_halving_one_at_width_one() {
        let linear =
            GaussNewtonConfig { max_iterations: 9, initial_width: 4.0, ..GaussNewtonConfig::default() };
        assert_eq!(widths(&linear, 1e-6).len(), 1);
        let halving = GaussNewtonConfig { schedule: WidthSchedule::Halving, ..linear };
        assert_eq!(widths(&halving, 1e-6), [4.0, 2.0, 1.0]);
    }
}
