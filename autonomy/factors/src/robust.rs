//! Wrong measurements among right ones: graduated non-convexity.
//!
//! A first guess is made with Cauchy's kernel, which lets go of nothing altogether. Then suspect factors cost truncated least squares, `min(s, c²)`. That is reached in stages: first a surrogate that is nearly convex, in
//! which every suspect has a say, then ever closer ones, in which suspects that the others contradict lose their weight.
//! Source: Yang, Antonante, Tzoumas, Carlone, *Graduated non-convexity for robust spatial perception*, RA-L 5, 2020. The threshold
//! follows the noise that is really there, since information matrices in files are often too timid.

use crate::batch::{Method, Options, optimise};
use crate::error::SolveError;
use crate::factor::{Factor, Linearised};
use crate::graph::{FactorId, Graph};
use crate::kernel::Kernel;
use crate::marginals::Marginals;
use crate::value::Values;
use nalgebra::{DMatrix, DVector};

/// When a suspect counts as wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobustOptions {
    /// A suspect is wrong once its squared residual is this many standard deviations (of its chi-squared distribution) too long.
    pub deviations: f64,
    /// Whether to tighten that where typical suspects are shorter than their information promises.
    pub learn_scale: bool,
    /// By how much the surrogate nears the truncated cost a stage.
    pub stage_factor: f64,
    /// Stages at most.
    pub stages_max: usize,
}

impl Default for RobustOptions {
    fn default() -> Self {
        Self { deviations: 3.5, learn_scale: true, stage_factor: 1.8, stages_max: 100 }
    }
}

/// What came out.
#[derive(Clone, Debug)]
pub struct RobustSolution {
    /// Estimates.
    pub values: Values,
    /// Chi-squared of the factors that were believed.
    pub cost: f64,
    /// Suspects that were not believed, ascending.
    pub rejected: Vec<FactorId>,
    /// Factorisations done.
    pub iterations: usize,
}

/// Iterations of the inner solver a stage: the next stage goes on from wherever they lead.
const ITERATIONS_A_STAGE: usize = 3;
/// Suspects whose residual is a smaller share of the limit are not reviewed: others would have to measure less than this share.
const REVIEW_SHARE: f64 = 0.05;
/// Share of a direction that others measure too, below which rounding decides.
const UNSHARED_MIN: f64 = 1e-6;
/// Times that what is believed is reviewed.
const REVIEWS: usize = 3;
/// Parameter of the Cauchy kernel for the first guess, standard deviations: wide enough to pull right loops in from far.
const FIRST_KERNEL: f64 = 1.0;
/// Closeness to begin with at least: suspects a hundred times beyond the limit after the first guess are wrong for certain.
const CLOSENESS_MIN: f64 = 0.01;

/// Minimises the cost of `graph` from `start`, believing only those factors for which `suspect` is true that agree with the
/// rest. The other factors must determine every variable.
///
/// Cost: some 20 to 60 iterations of [`optimise`], and a covariance for each suspect.
///
/// # Errors
/// As for [`optimise`].
pub fn optimise_robustly(
    graph: &Graph,
    start: &Values,
    suspect: impl Fn(FactorId, &dyn Factor) -> bool,
    options: &RobustOptions,
) -> Result<RobustSolution, SolveError> {
    let suspects: Vec<Suspect> = graph
        .iter()
        .filter(|(id, entry)| suspect(*id, &*entry.factor))
        .map(|(id, entry)| Suspect::new(id, entry.factor.rows(), options.deviations))
        .collect();
    let mut rounds = Rounds { full: graph, graph: graph.clone(), suspects, iterations: 0 };
    let mut values = rounds.first_guess(start)?;
    values = rounds.anneal(values, 1.0, options)?;
    if options.learn_scale {
        // Once only: each round cuts the tail off that the next would learn from.
        let scale = rounds.typical_scale(&values)?;
        values = rounds.anneal(values, scale, options)?;
    }
    let scale = if options.learn_scale { rounds.typical_scale(&values)? } else { 1.0 };
    // All that is believed, at full weight and to convergence.
    let mut solution = optimise(&rounds.graph, &values, &Options::default())?;
    for _ in 0..REVIEWS {
        if !rounds.review(&solution.values, scale)? {
            break;
        }
        rounds.iterations += solution.iterations;
        solution = optimise(&rounds.graph, &solution.values, &Options::default())?;
    }
    let rejected =
        rounds.suspects.iter().filter(|suspect| suspect.weight < 0.5).map(|suspect| suspect.id).collect();
    let iterations = rounds.iterations + solution.iterations;
    Ok(RobustSolution { values: solution.values, cost: solution.cost, rejected, iterations })
}

struct Suspect {
    id: FactorId,
    rows: f64,
    /// Squared residual beyond which it is wrong, at scale 1.
    limit: f64,
    weight: f64,
}

impl Suspect {
    /// Wilson and Hilferty's approximation of the chi-squared quantile.
    fn new(id: FactorId, rows: usize, deviations: f64) -> Self {
        let rows = rows as f64;
        let share = 2.0 / (9.0 * rows);
        Self { id, rows, limit: rows * (1.0 - share + deviations * share.sqrt()).powi(3), weight: 1.0 }
    }
}

struct Rounds<'a> {
    full: &'a Graph,
    /// The factors still believed, weighted.
    graph: Graph,
    suspects: Vec<Suspect>,
    iterations: usize,
}

impl Rounds<'_> {
    /// The solution with all suspects under a kernel that lets go slowly.
    fn first_guess(&mut self, start: &Values) -> Result<Values, SolveError> {
        let mut graph = self.full.clone();
        for suspect in &self.suspects {
            if let Some(entry) = graph.get_mut(suspect.id) {
                entry.kernel = Kernel::Cauchy(FIRST_KERNEL);
            }
        }
        let options = Options { relative_decrease_min: 1e-3, iterations_max: 30, ..Options::default() };
        let solution = optimise(&graph, start, &options)?;
        self.iterations += solution.iterations;
        Ok(solution.values)
    }

    /// From all suspects in to every suspect in or out.
    fn anneal(
        &mut self,
        mut values: Values,
        scale: f64,
        options: &RobustOptions,
    ) -> Result<Values, SolveError> {
        let inner = Options {
            method: Method::LevenbergMarquardt,
            iterations_max: ITERATIONS_A_STAGE,
            relative_decrease_min: 1e-3,
        };
        let squares = self.squares(&values)?;
        let excess = |(suspect, square): (&Suspect, &f64)| square / (suspect.limit * scale);
        let greatest = self.suspects.iter().zip(&squares).map(excess).fold(0.0, f64::max);
        if greatest <= 1.0 {
            self.suspects.iter_mut().for_each(|suspect| suspect.weight = 1.0);
            self.apply_weights();
            return Ok(values);
        }
        let mut closeness = (1.0 / (2.0 * greatest - 1.0)).max(CLOSENESS_MIN);
        for _ in 0..options.stages_max {
            let squares = self.squares(&values)?;
            for (suspect, square) in self.suspects.iter_mut().zip(squares) {
                suspect.weight = weight(square / (suspect.limit * scale), closeness);
            }
            self.apply_weights();
            let solution = optimise(&self.graph, &values, &inner)?;
            values = solution.values;
            self.iterations += solution.iterations;
            if self.suspects.iter().all(|suspect| suspect.weight == 0.0 || suspect.weight == 1.0) {
                break;
            }
            closeness *= options.stage_factor;
        }
        for suspect in &mut self.suspects {
            suspect.weight = suspect.weight.round();
        }
        self.apply_weights();
        Ok(values)
    }

    /// Squared residual of every suspect, believed or not.
    fn squares(&self, values: &Values) -> Result<Vec<f64>, SolveError> {
        // Both are by id.
        let mut all = self.full.squared(values)?.into_iter();
        let mut find = |id: FactorId| all.find(|(other, _)| *other == id).map_or(0.0, |(_, square)| square);
        Ok(self.suspects.iter().map(|suspect| find(suspect.id)).collect())
    }

    /// Suspects of weight zero leave the graph, so that they cost no fill; others come back.
    fn apply_weights(&mut self) {
        for suspect in &self.suspects {
            let absent = self.graph.get(suspect.id).is_none();
            if suspect.weight == 0.0 {
                // Absent already is as good.
                let _ = self.graph.remove(suspect.id);
                continue;
            }
            if absent && let Some(entry) = self.full.get(suspect.id) {
                self.graph.restore(suspect.id, entry.clone());
            }
            let original = self.full.get(suspect.id).map_or(1.0, |entry| entry.weight);
            if let Some(entry) = self.graph.get_mut(suspect.id) {
                entry.weight = original * suspect.weight;
            }
        }
    }

    /// Stops believing suspects that the graph *without them* contradicts, and says whether there were any. A wrong loop where nothing
    /// else measures bends the graph until its own residual is small; its innovation tells: with whitened residual `r`, Jacobian
    /// `J` and covariance `Σ` of the present solution, `rᵀ (I - J Σ Jᵀ)⁻¹ r` is what `s` would be had the suspect never been used.
    fn review(&mut self, values: &Values, scale: f64) -> Result<bool, SolveError> {
        let marginals = Marginals::new(&self.graph, values)?;
        let mut scratch = Linearised::default();
        let mut refuted = vec![false; self.suspects.len()];
        for (suspect, refuted) in self.suspects.iter().zip(&mut refuted) {
            let Some(entry) = self.graph.get(suspect.id) else { continue };
            scratch.reset(&*entry.factor);
            let done = entry.factor.linearise(values, &mut scratch);
            done.map_err(|source| SolveError::Factor { factor: suspect.id, source })?;
            if scratch.squared() < REVIEW_SHARE * suspect.limit * scale {
                continue;
            }
            let covariance = marginals.covariance(entry.factor.keys())?;
            let rows = entry.factor.rows();
            let stacked: Vec<f64> = scratch.columns().flatten().copied().collect();
            let jacobian =
                DMatrix::from_column_slice(rows, covariance.nrows(), &stacked[..rows * covariance.nrows()]);
            let residual = DVector::from_column_slice(scratch.negated_residual());
            let left = DMatrix::identity(rows, rows) - &jacobian * covariance * jacobian.transpose();
            // Where nothing else measures at all there is nothing to contradict it.
            let eigen = left.symmetric_eigen();
            let along = eigen.eigenvectors.transpose() * residual;
            let innovation: f64 = along
                .iter()
                .zip(eigen.eigenvalues.iter())
                .filter(|(_, share)| **share > UNSHARED_MIN)
                .map(|(component, share)| component * component / share)
                .sum();
            *refuted = innovation > suspect.limit * scale;
        }
        for (suspect, refuted) in self.suspects.iter_mut().zip(&refuted) {
            if *refuted {
                suspect.weight = 0.0;
            }
        }
        self.apply_weights();
        Ok(refuted.contains(&true))
    }

    /// How long the residuals of believed suspects typically are, as a share of what their information promises: at most 1.
    fn typical_scale(&self, values: &Values) -> Result<f64, SolveError> {
        let squares = self.squares(values)?;
        let believed = self.suspects.iter().zip(squares).filter(|(suspect, _)| suspect.weight > 0.5);
        let mut shares: Vec<f64> = believed.map(|(suspect, square)| square / suspect.rows).collect();
        shares.sort_unstable_by(f64::total_cmp);
        // A high quantile: real residuals have heavier tails than their median tells.
        let typical = shares.get(shares.len() * 9 / 10).copied().unwrap_or(1.0);
        Ok(typical.clamp(1e-12, 1.0))
    }
}

/// Weight of a squared residual, in units of the limit, at a closeness to the truncated cost.
fn weight(excess: f64, closeness: f64) -> f64 {
    if excess >= (closeness + 1.0) / closeness {
        0.0
    } else if excess <= closeness / (closeness + 1.0) {
        1.0
    } else {
        ((closeness * (closeness + 1.0) / excess).sqrt() - closeness).clamp(0.0, 1.0)
    }
}
