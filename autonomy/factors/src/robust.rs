//! Robust estimation with wrong loop closures: graduated non-convexity.
//!
//! The initial solution uses the Cauchy kernel, which never ignores a factor completely. Then suspect factors cost truncated least squares,
//! `min(s, c²)` (docs/maths/factors.md, equations 15 to 18). The truncated cost is approached in stages. The first surrogate is nearly convex
//! and uses every suspect. Each further stage is closer to the truncated cost, and suspects that the other factors contradict lose their weight.
//! The threshold follows the measured noise, because information matrices in files are often too small. Source: Yang, Antonante, Tzoumas,
//! Carlone, *Graduated non-convexity for robust spatial perception*, RA-L 5, 2020.

use crate::batch::{BatchConfig, Method, optimise};
use crate::error::SolveError;
use crate::factor::{Factor, Linearised};
use crate::graph::FactorGraph;
use crate::kernel::Kernel;
use crate::marginals::Marginals;
use crate::names::FactorId;
use crate::value::Values;
use nalgebra::{DMatrix, DVector};

/// Parameters of [`optimise_robustly`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobustConfig {
    /// A suspect is wrong when its squared residual lies more than this many standard deviations above the mean of its chi-squared distribution. Chosen: one right loop
    /// in some thousands is farther away by chance. Less rejects right ones, more keeps wrong ones that nearly fit.
    pub outlier_deviations: f64,
    /// Whether the limit is lowered where typical residuals are smaller than their information matrices predict. Chosen: information matrices of real data are often too
    /// small (docs/maths/factors.md).
    pub learn_scale: bool,
    /// Quantile of the accepted residuals that defines the scale. It is high, because real residuals have heavier tails than their median shows. Source:
    /// docs/maths/factors.md, the ninth decile.
    pub scale_quantile: f64,
    /// Growth of the surrogate's closeness μ per stage. Yang and others, 2020, use 1.4. Chosen larger for fewer stages; docs/benchmarks/pose-graphs.md has what it
    /// rejects.
    pub stage_factor: f64,
    /// Greatest number of stages. Chosen: at [`Self::stage_factor`] the closeness grows by 25 powers of ten in that number, so all suspects are decided long before.
    pub max_stages: usize,
    /// Iterations of the inner solver per stage. The next stage starts from the result. Chosen: a stage need not converge.
    pub stage_iterations: usize,
    /// Relative decrease at which the inner solver ends a stage, and the initial solution. Chosen: a thousand times that of the last solution
    /// ([`BatchConfig::min_relative_decrease`]), because the next stage goes on from the result.
    pub min_stage_decrease: f64,
    /// Greatest number of iterations of the initial solution. Chosen: a bound on the time; the stages go on from what was reached.
    pub max_first_guess_iterations: usize,
    /// Parameter of the Cauchy kernel for the initial solution, standard deviations. Wide enough to attract right loops from far away. Chosen: one standard deviation.
    pub first_guess_kernel: f64,
    /// Lowest closeness μ of the first stage. A suspect a hundred times beyond the limit after the initial solution is certainly wrong. Chosen: it bounds the number of
    /// stages.
    pub min_closeness: f64,
    /// Suspects whose squared residual is a smaller share of the limit are not reviewed. They could only be wrong if the other factors measured
    /// less than this share of their directions. Chosen as a round number: less reviews more suspects, and each review costs a marginal covariance.
    pub min_review_residual_share: f64,
    /// Greatest number of reviews of the accepted suspects. Chosen: a rejected suspect can uncover another one.
    pub max_reviews: usize,
    /// Share of a direction that other factors must measure as well. Below it, rounding would decide. Chosen: far above the rounding of the covariances and far below
    /// what a loop measures.
    pub min_shared_information: f64,
}

impl Default for RobustConfig {
    fn default() -> Self {
        Self {
            outlier_deviations: 3.5,
            learn_scale: true,
            scale_quantile: 0.9,
            stage_factor: 1.8,
            max_stages: 100,
            stage_iterations: 3,
            min_stage_decrease: 1e-3,
            max_first_guess_iterations: 30,
            first_guess_kernel: 1.0,
            min_closeness: 0.01,
            min_review_residual_share: 0.05,
            max_reviews: 3,
            min_shared_information: 1e-6,
        }
    }
}

/// Result of [`optimise_robustly`].
#[derive(Clone, Debug)]
pub struct RobustSolution {
    /// Estimates.
    pub values: Values,
    /// Chi-squared of the accepted factors.
    pub cost: f64,
    /// Rejected suspects, ascending.
    pub rejected: Vec<FactorId>,
    /// Number of factorisations.
    pub iterations: usize,
}

/// Minimises the cost of `graph` from `start`. A factor for which `suspect` is true is only used if it agrees with the others. The other factors
/// must determine every variable.
///
/// Cost: 20 to 60 iterations of [`optimise`], and a covariance for each suspect.
///
/// # Errors
/// As for [`optimise`].
pub fn optimise_robustly(
    graph: &FactorGraph,
    start: &Values,
    suspect: impl Fn(FactorId, &dyn Factor) -> bool,
    config: &RobustConfig,
) -> Result<RobustSolution, SolveError> {
    let suspects: Vec<Suspect> = graph
        .iter()
        .filter(|(id, entry)| suspect(*id, &*entry.factor))
        .map(|(id, entry)| Suspect::new(id, entry.factor.rows(), config.outlier_deviations))
        .collect();
    let mut rounds = Rounds { config: *config, full: graph, graph: graph.clone(), suspects, iterations: 0 };
    let mut values = rounds.first_guess(start)?;
    values = rounds.anneal(values, 1.0)?;
    if config.learn_scale {
        // Done only once: each run removes the tail from which the next scale would be computed.
        let scale = rounds.typical_scale(&values)?;
        values = rounds.anneal(values, scale)?;
    }
    let scale = if config.learn_scale { rounds.typical_scale(&values)? } else { 1.0 };
    // All accepted factors, at full weight, until convergence.
    let mut solution = optimise(&rounds.graph, &values, &BatchConfig::default())?;
    for _ in 0..config.max_reviews {
        if !rounds.review(&solution.values, scale)? {
            break;
        }
        rounds.iterations += solution.iterations;
        solution = optimise(&rounds.graph, &solution.values, &BatchConfig::default())?;
    }
    let rejected =
        rounds.suspects.iter().filter(|suspect| suspect.weight < 0.5).map(|suspect| suspect.id).collect();
    let iterations = rounds.iterations + solution.iterations;
    Ok(RobustSolution { values: solution.values, cost: solution.cost, rejected, iterations })
}

struct Suspect {
    id: FactorId,
    rows: f64,
    /// Squared residual above which the suspect is rejected, at scale 1.
    limit: f64,
    weight: f64,
}

impl Suspect {
    /// Wilson and Hilferty's approximation of the chi-squared quantile (docs/maths/factors.md, equation 16).
    fn new(id: FactorId, rows: usize, deviations: f64) -> Self {
        let rows = rows as f64;
        let share = 2.0 / (9.0 * rows);
        Self { id, rows, limit: rows * (1.0 - share + deviations * share.sqrt()).powi(3), weight: 1.0 }
    }
}

struct Rounds<'a> {
    config: RobustConfig,
    full: &'a FactorGraph,
    /// The factors in use, with their weights.
    graph: FactorGraph,
    suspects: Vec<Suspect>,
    iterations: usize,
}

impl Rounds<'_> {
    /// The solution with the Cauchy kernel on all suspects.
    fn first_guess(&mut self, start: &Values) -> Result<Values, SolveError> {
        let mut graph = self.full.clone();
        for suspect in &self.suspects {
            if let Some(entry) = graph.get_mut(suspect.id) {
                entry.kernel = Kernel::Cauchy(self.config.first_guess_kernel);
            }
        }
        let batch = BatchConfig {
            min_relative_decrease: self.config.min_stage_decrease,
            max_iterations: self.config.max_first_guess_iterations,
            ..BatchConfig::default()
        };
        let solution = optimise(&graph, start, &batch)?;
        self.iterations += solution.iterations;
        Ok(solution.values)
    }

    /// Runs the stages until each suspect is either accepted or rejected.
    fn anneal(&mut self, mut values: Values, scale: f64) -> Result<Values, SolveError> {
        let inner = BatchConfig {
            method: Method::LevenbergMarquardt,
            max_iterations: self.config.stage_iterations,
            min_relative_decrease: self.config.min_stage_decrease,
            ..BatchConfig::default()
        };
        let squares = self.squares(&values)?;
        let excess = |(suspect, square): (&Suspect, &f64)| square / (suspect.limit * scale);
        let greatest = self.suspects.iter().zip(&squares).map(excess).fold(0.0, f64::max);
        if greatest <= 1.0 {
            self.suspects.iter_mut().for_each(|suspect| suspect.weight = 1.0);
            self.apply_weights();
            return Ok(values);
        }
        // Equation 18.
        let mut closeness = (1.0 / (2.0 * greatest - 1.0)).max(self.config.min_closeness);
        for _ in 0..self.config.max_stages {
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
            closeness *= self.config.stage_factor;
        }
        for suspect in &mut self.suspects {
            suspect.weight = suspect.weight.round();
        }
        self.apply_weights();
        Ok(values)
    }

    /// Squared residual of every suspect, accepted or rejected.
    fn squares(&self, values: &Values) -> Result<Vec<f64>, SolveError> {
        // Both lists are sorted by id.
        let mut all = self.full.squared(values)?.into_iter();
        let mut find = |id: FactorId| all.find(|(other, _)| *other == id).map_or(0.0, |(_, square)| square);
        Ok(self.suspects.iter().map(|suspect| find(suspect.id)).collect())
    }

    /// Removes suspects of weight zero from the graph, so that they cause no fill. Restores the others.
    fn apply_weights(&mut self) {
        for suspect in &self.suspects {
            let absent = self.graph.get(suspect.id).is_none();
            if suspect.weight == 0.0 {
                // It may have been removed before.
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

    /// Rejects suspects that the graph *without them* contradicts. Returns whether there were any. If few other factors constrain a part of the
    /// graph, a wrong loop deforms it until its own residual is small. Its innovation reveals it (docs/maths/factors.md, equation 19): with
    /// whitened residual `r`, Jacobian `J` and covariance `Σ` of the present solution, `rᵀ (I - J Σ Jᵀ)⁻¹ r` is the squared residual that the
    /// suspect would have if it had not been used.
    fn review(&mut self, values: &Values, scale: f64) -> Result<bool, SolveError> {
        let marginals = Marginals::new(&self.graph, values)?;
        let mut scratch = Linearised::default();
        let mut refuted = vec![false; self.suspects.len()];
        for (suspect, refuted) in self.suspects.iter().zip(&mut refuted) {
            let Some(entry) = self.graph.get(suspect.id) else { continue };
            scratch.reset(&*entry.factor);
            let done = entry.factor.linearise(values, &mut scratch);
            done.map_err(|source| SolveError::Factor { factor: suspect.id, source })?;
            if scratch.squared() < self.config.min_review_residual_share * suspect.limit * scale {
                continue;
            }
            let covariance = marginals.covariance(entry.factor.keys())?;
            let rows = entry.factor.rows();
            let stacked: Vec<f64> = scratch.columns().flatten().copied().collect();
            let jacobian =
                DMatrix::from_column_slice(rows, covariance.nrows(), &stacked[..rows * covariance.nrows()]);
            let residual = DVector::from_column_slice(scratch.negated_residual());
            let left = DMatrix::identity(rows, rows) - &jacobian * covariance * jacobian.transpose();
            // Directions that no other factor measures cannot contradict the suspect.
            let eigen = left.symmetric_eigen();
            let along = eigen.eigenvectors.transpose() * residual;
            let innovation: f64 = along
                .iter()
                .zip(eigen.eigenvalues.iter())
                .filter(|(_, share)| **share > self.config.min_shared_information)
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

    /// Squared residual of the accepted suspects at the quantile `scale_quantile`, as a share of the predicted one. At most 1.
    fn typical_scale(&self, values: &Values) -> Result<f64, SolveError> {
        let squares = self.squares(values)?;
        let believed = self.suspects.iter().zip(squares).filter(|(suspect, _)| suspect.weight > 0.5);
        let mut shares: Vec<f64> = believed.map(|(suspect, square)| square / suspect.rows).collect();
        shares.sort_unstable_by(f64::total_cmp);
        let index = (shares.len() as f64 * self.config.scale_quantile) as usize;
        let typical = shares.get(index).copied().unwrap_or(1.0);
        Ok(typical.clamp(1e-12, 1.0))
    }
}

/// Weight of a squared residual `excess`, in units of the limit, at a closeness μ to the truncated cost (equation 17).
fn weight(excess: f64, closeness: f64) -> f64 {
    if excess >= (closeness + 1.0) / closeness {
        0.0
    } else if excess <= closeness / (closeness + 1.0) {
        1.0
    } else {
        ((closeness * (closeness + 1.0) / excess).sqrt() - closeness).clamp(0.0, 1.0)
    }
}
