//! The table that is printed.

use anyhow::Result;

/// The results of both programs for one graph and one mode. `None` where a program did not run or the figure does not apply.
pub struct Row {
    /// Name of the graph.
    pub graph: String,
    /// Mode: batch or pose by pose.
    pub mode: &'static str,
    /// CPU time of our program, seconds.
    pub ours: Option<f64>,
    /// CPU time of GTSAM, seconds.
    pub gtsam: Option<f64>,
    /// Chi-squared of our result.
    pub chi2: Option<f64>,
    /// Chi-squared of GTSAM's result.
    pub gtsam_chi2: Option<f64>,
    /// Published chi-squared, for the residual that is the logarithm of the relative pose.
    pub optimum: Option<f64>,
    /// 99th percentile of a step, milliseconds.
    pub p99_ms: Option<f64>,
    /// 99th percentile of GTSAM's step, milliseconds.
    pub gtsam_p99_ms: Option<f64>,
    /// Peak resident memory, MB.
    pub peak_mb: Option<f64>,
    /// Peak resident memory of GTSAM with its Python, MB.
    pub gtsam_peak_mb: Option<f64>,
}

/// Names of the columns.
#[allow(clippy::print_stdout, reason = "the table is this program's output")]
pub fn print_header() {
    println!(
        "{:<16}{:<14}{:>9}{:>9}{:>7}{:>13}{:>13}{:>13}{:>9}{:>9}{:>7}{:>7}",
        "graph",
        "mode",
        "ours s",
        "GTSAM s",
        "ratio",
        "chi2",
        "GTSAM chi2",
        "optimum",
        "p99 ms",
        "GTSAM",
        "MB",
        "GTSAM"
    );
}

/// Prints one row.
#[allow(clippy::print_stdout, reason = "the table is this program's output")]
pub fn print(row: &Row) {
    let show =
        |value: Option<f64>, digits: usize| value.map_or_else(|| "-".to_owned(), |v| format!("{v:.digits$}"));
    let ratio = row.ours.zip(row.gtsam).map(|(ours, gtsam)| ours / gtsam);
    println!(
        "{:<16}{:<14}{:>9}{:>9}{:>7}{:>13}{:>13}{:>13}{:>9}{:>9}{:>7}{:>7}",
        row.graph,
        row.mode,
        show(row.ours, 4),
        show(row.gtsam, 4),
        show(ratio, 2),
        show(row.chi2, 4),
        show(row.gtsam_chi2, 4),
        show(row.optimum, 4),
        show(row.p99_ms, 2),
        show(row.gtsam_p99_ms, 2),
        show(row.peak_mb, 0),
        show(row.gtsam_peak_mb, 0)
    );
}

/// Prints a note on standard error.
pub fn note(sentence: &str) -> Result<()> {
    eprintln!("{sentence}");
    Ok(())
}
