//! The text of a cost map.

use super::CostMap;
use crate::caster::Fullness;
use crate::stats::RULE;
use std::fmt;

/// A cost map and its grid. `Display` prints a block in the form of the statistics.
#[derive(Clone, Debug)]
pub struct CostReport {
    /// The map.
    pub map: CostMap,
    /// The occupancy of the grid's cells. `None` without a grid.
    pub cells: Option<Fullness>,
}

impl fmt::Display for CostReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{RULE}\nCOST MAP")?;
        let mut line = |label: &str, value: String| writeln!(f, "  {label:<27}{value}");
        let ([x, y], most) = self.map.most_expensive();
        let pixels = self.map.counts.len().max(1);
        let total = self.map.total();
        line("cost", self.map.cost.name().into())?;
        line("total", total.to_string())?;
        line("per pixel", format!("{:.1}", total as f64 / pixels as f64))?;
        line("most expensive pixel", format!("{most} at ({x}, {y})"))?;
        if let Some(Fullness { fullest, empty, cells }) = &self.cells {
            line("empty cells", format!("{:.1}%", 100.0 * *empty as f64 / (*cells).max(1) as f64))?;
            for ([i, j, k], primitives) in fullest {
                line("full cell", format!("{primitives} primitives at ({i}, {j}, {k})"))?;
            }
        }
        writeln!(f, "{RULE}")
    }
}
