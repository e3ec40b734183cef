//! The answer to a target: the setting to choose, as a command line.

use super::{ErrorReport, Measurement, Setting};

/// The targets answered if the user gives none, in levels.
pub const USUAL_TARGETS: [f64; 4] = [0.5, 1.0, 2.0, 4.0];

/// The setting chosen for a target.
#[derive(Clone, Debug)]
pub struct Answer<'a> {
    /// The target: the largest permitted root mean square error, in levels.
    pub target: f64,
    /// The cheapest setting that reaches the target, or the nearest one if none does.
    pub chosen: &'a Measurement,
    /// The command line of the setting: the program, then each flag with its values.
    pub command: Vec<String>,
}

impl<'a> Answer<'a> {
    /// Chooses among all settings that flags can express, with any samples and filter. `None` if nothing was measured.
    pub fn new(
        report: &'a ErrorReport,
        target: f64,
        command: impl Fn(&Setting) -> Vec<String>,
    ) -> Option<Self> {
        let cheaper = |a: &&Measurement, b: &&Measurement| a.least().total_cmp(&b.least());
        let nearer = |a: &&Measurement, b: &&Measurement| a.error.total_cmp(&b.error).then(cheaper(a, b));
        let cheapest = report.candidates().filter(|one| one.error <= target).min_by(cheaper);
        let chosen = cheapest.or_else(|| report.candidates().min_by(nearer))?;
        Some(Self { target, chosen, command: command(&chosen.setting) })
    }

    /// Returns true if the setting reaches the target.
    pub fn is_reached(&self) -> bool {
        self.chosen.error <= self.target
    }
}
