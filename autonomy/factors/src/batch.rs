//! Whole graphs at once: Gauss-Newton, Levenberg-Marquardt, Dogleg.
//!
//! The elimination order and the structure of the factor are computed once. Every iteration linearises all factors, factorises the normal
//! equations and moves all variables. Source: Madsen, Nielsen, Tingleff, *Methods for non-linear least squares problems*, 2004 (damping and
//! trust region).

use crate::error::SolveError;
use crate::factor::Linearised;
use crate::graph::FactorGraph;
use crate::linear::dense::{Stored, dot};
use crate::linear::factorisation::{EliminationPlan, Factorisation, System, products};
use crate::names::{FactorId, Key};
use crate::value::Values;
use nalgebra::DMatrix;

/// Step rule of the solver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Full steps, even where the cost rises. Fastest from a start near the optimum.
    GaussNewton,
    /// Damped steps; the cost never rises.
    #[default]
    LevenbergMarquardt,
    /// Steps within a trust region, between steepest descent and Gauss-Newton; the cost never rises.
    Dogleg,
}

/// Parameters of [`Method::LevenbergMarquardt`]. The damping is relative to the diagonal of the normal equations. Update rule of Nielsen; source:
/// Madsen, Nielsen, Tingleff, section 3.2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DampingConfig {
    /// Damping of the first step. Near zero, because most graphs start close to the optimum. Chosen: a larger one shortens the first steps of such graphs, and a smaller
    /// one costs a poor start further attempts.
    pub initial: f64,
    /// Least damping after a step that was taken. Chosen: a thousand times the rounding of a double, so that the damping still changes the diagonal.
    pub min: f64,
    /// The solver gives up at this damping: its steps are too short to change anything. Chosen: steps are shorter than a gradient step by this factor.
    pub max: f64,
    /// Below this damping, a singular system is damped more strongly. Above it, the variable counts as undetermined. Chosen: a direction that factors measure at all is
    /// determined with far less.
    pub max_singular: f64,
    /// Factor of the damping after a singular system. Chosen: from [`Self::initial`] two attempts reach [`Self::max_singular`].
    pub singular_growth: f64,
    /// Factor of the damping after a step that raised the cost. It doubles with each further one. Nielsen's rule begins with 2; chosen larger, because each attempt costs
    /// a factorisation.
    pub first_growth: f64,
    /// Least factor of the damping after a step that lowered the cost as predicted. Nielsen's rule has 1/3; chosen smaller, because most graphs start close to the
    /// optimum.
    pub min_decrease: f64,
    /// Greatest factor of the damping after a step that lowered the cost less than predicted. Source: the value of Nielsen's rule for a step that gains nothing.
    pub max_increase: f64,
}

impl Default for DampingConfig {
    fn default() -> Self {
        Self {
            initial: 1e-6,
            min: 1e-12,
            max: 1e10,
            max_singular: 1e-3,
            singular_growth: 100.0,
            first_growth: 4.0,
            min_decrease: 0.1,
            max_increase: 2.0,
        }
    }
}

/// Parameters of the trust region of [`Method::Dogleg`]. The values are those of Madsen, Nielsen, Tingleff, section 3.3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrustRegionConfig {
    /// The region grows after a step whose actual decrease of the cost is more than this share of the predicted one. Source: Madsen, Nielsen, Tingleff, section 3.3.
    pub good_ratio: f64,
    /// The region shrinks after a step whose actual decrease is less than this share of the predicted one. Source: as [`Self::good_ratio`].
    pub poor_ratio: f64,
    /// Radius after a good step, in lengths of the step. Source: as [`Self::good_ratio`].
    pub growth: f64,
    /// Radius after a poor step, in lengths of the step. Source: as [`Self::good_ratio`].
    pub shrinkage: f64,
}

impl Default for TrustRegionConfig {
    fn default() -> Self {
        Self { good_ratio: 0.75, poor_ratio: 0.25, growth: 3.0, shrinkage: 0.5 }
    }
}

/// Step rule, its parameters and stopping criteria of [`optimise`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatchConfig {
    /// Step rule. Chosen: Levenberg-Marquardt also converges from a poor start.
    pub method: Method,
    /// Greatest number of linearisations. Chosen: a bound on the time, far above what graphs take that converge.
    pub max_iterations: usize,
    /// Iterations stop once the actual or the predicted relative decrease of the cost in one iteration is below this value. Chosen: a decrease by a millionth of the cost
    /// moves poses by far less than their standard deviations.
    pub min_relative_decrease: f64,
    /// Costs below this count as zero. Rounding of any real measurement costs more. Chosen: it is a residual of a billionth of a standard deviation.
    pub zero_cost: f64,
    /// A rise of the cost by less than this share of it is rounding, so the step is taken. The last decrease may be smaller than rounding. Chosen: a sum of thousands of
    /// squares in double precision is good to that.
    pub relative_rounding: f64,
    /// From this number of variables on, the factor is stored in single precision, which halves its memory. It is computed in double precision.
    /// Residuals and gradients stay in double precision, so only the steps are rounded, and the next iteration corrects that. Chosen: smaller graphs need little memory
    /// either way.
    pub single_precision_variables: usize,
    /// Parameters of [`Method::LevenbergMarquardt`].
    pub damping: DampingConfig,
    /// Parameters of [`Method::Dogleg`].
    pub trust_region: TrustRegionConfig,
}

impl Default for BatchConfig {
    fn default() -> Self {
        Self {
            method: Method::default(),
            max_iterations: 100,
            min_relative_decrease: 1e-6,
            zero_cost: 1e-18,
            relative_rounding: 1e-12,
            single_precision_variables: 10_000,
            damping: DampingConfig::default(),
            trust_region: TrustRegionConfig::default(),
        }
    }
}

/// Result of [`optimise`].
#[derive(Clone, Debug)]
pub struct Solution {
    /// Estimates.
    pub values: Values,
    /// Sum of the factors' costs `ρ(s) · weight`; chi-squared where no factor has a kernel or weight.
    pub cost: f64,
    /// The same sum at the start.
    pub initial_cost: f64,
    /// Number of factorisations.
    pub iterations: usize,
    /// Whether the solver stopped because the cost no longer fell.
    pub converged: bool,
}

/// Minimises the cost of `graph` from `start`.
///
/// Cost: one linearisation of every factor and one sparse factorisation per iteration. For pose graphs of robots that revisit places, memory
/// grows about as `n log n` and time about as `n^1.5`.
///
/// # Errors
/// When a variable is not determined, or a factor cannot be evaluated at an estimate.
pub fn optimise(graph: &FactorGraph, start: &Values, config: &BatchConfig) -> Result<Solution, SolveError> {
    if start.len() < config.single_precision_variables {
        optimise_with::<f64>(graph, start, config)
    } else {
        optimise_with::<f32>(graph, start, config)
    }
}

fn optimise_with<T: Stored>(
    graph: &FactorGraph,
    start: &Values,
    config: &BatchConfig,
) -> Result<Solution, SolveError> {
    let mut problem = LinearisedProblem::<T>::new(graph, start);
    let initial_cost = problem.linearise(start)?;
    let state =
        State { values: start.clone(), cost: initial_cost, initial_cost, iterations: 0, converged: false };
    if start.is_empty() {
        return Ok(Solution { converged: true, ..state });
    }
    match config.method {
        Method::GaussNewton => gauss_newton(&mut problem, state, config),
        Method::LevenbergMarquardt => levenberg_marquardt(&mut problem, state, config),
        Method::Dogleg => dogleg(&mut problem, state, config),
    }
}

type State = Solution;

fn gauss_newton<T: Stored>(
    problem: &mut LinearisedProblem<T>,
    mut state: State,
    config: &BatchConfig,
) -> Result<Solution, SolveError> {
    while state.iterations < config.max_iterations {
        let step = problem.step(&[])?;
        state.iterations += 1;
        state.values = state.values.retract(&step.errors);
        if step.promised <= config.min_relative_decrease * state.cost + config.zero_cost {
            // The remaining decrease is of second order in the predicted one, so the factors need not be linearised again.
            state.cost = problem.cost(&state.values)?;
            state.converged = true;
            break;
        }
        let cost = problem.linearise(&state.values)?;
        let gain = (state.cost - cost).abs();
        state.cost = cost;
        if gain <= config.min_relative_decrease * cost {
            state.converged = true;
            break;
        }
    }
    Ok(state)
}

fn levenberg_marquardt<T: Stored>(
    problem: &mut LinearisedProblem<T>,
    mut state: State,
    config: &BatchConfig,
) -> Result<Solution, SolveError> {
    let rule = &config.damping;
    let mut damping = rule.initial;
    let mut growth = rule.first_growth;
    let mut diagonal = problem.system.diagonal();
    while state.iterations < config.max_iterations && damping < rule.max {
        let extra: Vec<f64> = diagonal.iter().map(|entry| entry * damping).collect();
        let step = match problem.step(&extra) {
            Ok(step) => step,
            Err(SolveError::Undetermined { key }) if damping < rule.max_singular => {
                // The system is numerically singular, perhaps only at this estimate.
                let _ = key;
                damping *= rule.singular_growth;
                continue;
            }
            Err(error) => return Err(error),
        };
        state.iterations += 1;
        let candidate = state.values.retract(&step.errors);
        problem.keep_system();
        let cost = problem.linearise(&candidate)?;
        let gain = state.cost - cost;
        if gain >= -config.relative_rounding * state.cost {
            // The gain ratio (docs/maths/factors.md, equation 9).
            let quality = if step.promised > 0.0 { gain / step.promised } else { 1.0 };
            (state.values, state.cost) = (candidate, cost);
            let least = config.min_relative_decrease * cost + config.zero_cost;
            if gain <= least || step.promised <= least {
                state.converged = true;
                break;
            }
            // Equation 10.
            let factor = 1.0 - (2.0 * quality - 1.0).powi(3);
            damping = (damping * factor.clamp(rule.min_decrease, rule.max_increase)).max(rule.min);
            growth = rule.first_growth;
            diagonal = problem.system.diagonal();
        } else {
            problem.restore_system();
            if step.promised <= config.min_relative_decrease * state.cost {
                state.converged = true;
                break;
            }
            damping *= growth;
            growth *= 2.0;
        }
    }
    Ok(state)
}

fn dogleg<T: Stored>(
    problem: &mut LinearisedProblem<T>,
    mut state: State,
    config: &BatchConfig,
) -> Result<Solution, SolveError> {
    let rule = &config.trust_region;
    let length = |vector: &[f64]| dot(vector, vector).sqrt();
    let mut radius = f64::INFINITY;
    'linearised: while state.iterations < config.max_iterations {
        let newton = problem.step(&[])?;
        state.iterations += 1;
        let gradient = problem.system.gradient();
        let curvature = dot(&gradient, &problem.system.multiply(&gradient));
        let scale = if curvature > 0.0 { dot(&gradient, &gradient) / curvature } else { 0.0 };
        let steepest: Vec<f64> = gradient.iter().map(|entry| entry * scale).collect();
        loop {
            let errors = blend(&newton.errors, &steepest, radius);
            let promised = 2.0 * dot(&gradient, &errors) - dot(&errors, &problem.system.multiply(&errors));
            let candidate = state.values.retract(&errors);
            problem.keep_system();
            let cost = problem.linearise(&candidate)?;
            let gain = state.cost - cost;
            let least = config.min_relative_decrease * state.cost + config.zero_cost;
            if gain >= -config.relative_rounding * state.cost {
                (state.values, state.cost) = (candidate, cost);
                if gain <= least || promised <= least {
                    state.converged = true;
                    break 'linearised;
                }
                if gain > rule.good_ratio * promised {
                    radius = radius.max(rule.growth * length(&errors));
                } else if gain < rule.poor_ratio * promised {
                    radius = rule.shrinkage * length(&errors);
                }
                break;
            }
            problem.restore_system();
            if promised <= least {
                state.converged = true;
                break 'linearised;
            }
            radius = rule.shrinkage * length(&errors);
        }
    }
    Ok(state)
}

/// The point where the path from the start along `steepest` and then on to `newton` leaves the trust region.
fn blend(newton: &[f64], steepest: &[f64], radius: f64) -> Vec<f64> {
    let squared = radius * radius;
    if dot(newton, newton) <= squared {
        return newton.to_vec();
    }
    let descent = dot(steepest, steepest);
    if descent >= squared {
        let share = radius / descent.sqrt();
        return steepest.iter().map(|entry| entry * share).collect();
    }
    let difference: Vec<f64> = newton.iter().zip(steepest).map(|(n, s)| n - s).collect();
    let (a, b) = (dot(&difference, &difference), dot(steepest, &difference));
    let share = (-b + (b * b + a * (squared - descent)).max(0.0).sqrt()) / a;
    steepest.iter().zip(&difference).map(|(s, d)| s + share * d).collect()
}

/// A Gauss-Newton or damped step.
struct Step {
    /// Error vectors of all variables in the order of their keys.
    errors: Vec<f64>,
    /// Predicted decrease: by how much the linearised cost falls.
    promised: f64,
}

/// A graph with the buffers that its iterations share.
#[derive(Debug)]
pub(crate) struct LinearisedProblem<'a, T = f64> {
    graph: &'a FactorGraph,
    ids: Vec<FactorId>,
    system: System,
    other_system: Option<System>,
    plan: EliminationPlan,
    factorisation: Factorisation<T>,
    scratch: Linearised,
}

impl<'a, T: Stored> LinearisedProblem<'a, T> {
    pub(crate) fn new(graph: &'a FactorGraph, values: &Values) -> Self {
        let dimensions = values.iter().map(|(_, value)| value.kind().dimension() as u8).collect();
        let mut system = System::new(dimensions, 1);
        let mut ids = Vec::with_capacity(graph.ids());
        let mut variables = Vec::new();
        for (id, entry) in graph.iter() {
            variables.clear();
            variables.extend(entry.factor.keys().iter().map(|key| key.0));
            system.push(&variables);
            ids.push(id);
        }
        let plan = EliminationPlan::new(&system);
        Self {
            graph,
            ids,
            system,
            other_system: None,
            plan,
            factorisation: Factorisation::new(),
            scratch: Linearised::default(),
        }
    }

    /// Writes all normal equations at `values` and returns the cost.
    pub(crate) fn linearise(&mut self, values: &Values) -> Result<f64, SolveError> {
        let mut sum = 0.0;
        for (index, &id) in self.ids.iter().enumerate() {
            let Some(entry) = self.graph.get(id) else { continue };
            self.scratch.reset(&*entry.factor);
            let done = entry.factor.linearise(values, &mut self.scratch);
            done.map_err(|source| SolveError::Factor { factor: id, source })?;
            let (cost, weight) = entry.evaluate(self.scratch.squared());
            if !cost.is_finite() {
                return Err(not_finite(self.graph, id));
            }
            sum += cost;
            self.scratch.normal_equations(weight, self.system.values_mut(index));
        }
        Ok(sum)
    }

    /// The cost at `values`.
    fn cost(&mut self, values: &Values) -> Result<f64, SolveError> {
        let mut sum = 0.0;
        for &id in &self.ids {
            let Some(entry) = self.graph.get(id) else { continue };
            self.scratch.reset(&*entry.factor);
            let done = entry.factor.residual(values, &mut self.scratch);
            done.map_err(|source| SolveError::Factor { factor: id, source })?;
            sum += entry.evaluate(self.scratch.squared()).0;
        }
        Ok(sum)
    }

    /// Solves the system with `damping` added to its diagonal. The predicted decrease is the denominator of equation 9.
    fn step(&mut self, damping: &[f64]) -> Result<Step, SolveError> {
        self.factorise(damping)?;
        let errors = self.factorisation.solve(&self.plan, &self.system.dimensions, 0);
        let damped: f64 = damping.iter().zip(&errors).map(|(entry, error)| entry * error * error).sum();
        let promised =
            self.factorisation.squared_right_hand_side(&self.plan, &self.system.dimensions) + damped;
        Ok(Step { errors, promised })
    }

    pub(crate) fn factorise(&mut self, damping: &[f64]) -> Result<(), SolveError> {
        let done = self.factorisation.factorise(&self.plan, &self.system, damping);
        done.map_err(|undetermined| {
            // A Jacobian with entries that are not finite is noticed only here.
            let culprit = (0..self.system.len())
                .find(|&index| self.system.values(index).iter().any(|value| !value.is_finite()));
            match culprit {
                Some(index) => not_finite(self.graph, self.ids[index]),
                None => SolveError::Undetermined { key: Key(undetermined.0) },
            }
        })
    }

    /// Joint covariance of some variables at the last factorisation.
    pub(crate) fn covariance(&self, keys: &[Key]) -> DMatrix<f64> {
        let variables: Vec<u32> = keys.iter().map(|key| key.0).collect();
        let columns = self.factorisation.forward(&self.plan, &self.system.dimensions, &variables);
        DMatrix::from_vec(columns.len(), columns.len(), products(&columns))
    }

    /// Keeps a copy of the present system, so that the next linearisation does not overwrite it.
    fn keep_system(&mut self) {
        let spare = self.other_system.take().unwrap_or_else(|| self.system.clone());
        self.other_system = Some(std::mem::replace(&mut self.system, spare));
    }

    /// Restores the system kept by [`Self::keep_system`].
    fn restore_system(&mut self) {
        if let Some(kept) = self.other_system.take() {
            self.other_system = Some(std::mem::replace(&mut self.system, kept));
        }
    }
}

fn not_finite(graph: &FactorGraph, factor: FactorId) -> SolveError {
    let key = graph.get(factor).and_then(|entry| entry.factor.keys().first().copied());
    SolveError::NotFinite { factor, key: key.unwrap_or(Key(0)) }
}
