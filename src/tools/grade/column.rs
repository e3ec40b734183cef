//! One picture, as submitted by all names.

use crate::picture::Picture;
use crate::tools::causes::Finding;
use crate::tools::compare::{Comparison, Tolerance, common_size};

/// A submission.
#[derive(Clone, Debug)]
pub enum Submission {
    /// A picture of the reference's size.
    Picture(Picture),
    /// No file.
    Missing,
    /// A file that is not a picture of the reference's size, and the reason.
    Unusable(String),
}

/// One picture, as submitted by all names.
#[derive(Clone, Debug)]
pub struct Column {
    /// Its name.
    pub picture: String,
    /// The reason why there is no reference, if there is none.
    pub problem: Option<String>,
    /// The results, one for each name.
    pub cells: Vec<Cell>,
    /// For each name, the path of the file used, if it differs from the picture's name.
    pub found_as: Vec<Option<String>>,
}

/// The result of one picture of one name.
#[derive(Clone, Debug)]
pub enum Cell {
    Equal,
    Different {
        comparison: Box<Comparison>,
        /// True if the tolerance accepts it.
        passes: bool,
        /// The cause, if one was searched for and found.
        cause: Option<Finding>,
        /// Its index among the different pictures of the column.
        picture: usize,
    },
    /// There is no picture.
    Missing,
    /// There is no readable picture of the reference's size. Contains the reason.
    Unusable(String),
    /// There is no reference.
    Ungraded,
}

/// The verdict of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellWord {
    Passed,
    Failed,
    Missing,
    Unusable,
    Ungraded,
}

impl CellWord {
    /// The verdicts of pictures that have a reference.
    pub const COUNTED: [Self; 4] = [Self::Passed, Self::Failed, Self::Missing, Self::Unusable];

    pub fn word(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Failed => "failed",
            Self::Missing => "missing",
            Self::Unusable => "unusable",
            Self::Ungraded => "no reference",
        }
    }

    /// Returns the mark of a cell in a page.
    pub fn mark(self) -> &'static str {
        match self {
            Self::Passed => "\u{2713}",
            Self::Failed => "\u{2717}",
            Self::Missing => "\u{2013} missing",
            Self::Unusable => "! unusable",
            Self::Ungraded => "?",
        }
    }
}

impl Cell {
    pub fn verdict(&self) -> CellWord {
        match self {
            Self::Equal | Self::Different { passes: true, .. } => CellWord::Passed,
            Self::Different { passes: false, .. } => CellWord::Failed,
            Self::Missing => CellWord::Missing,
            Self::Unusable(_) => CellWord::Unusable,
            Self::Ungraded => CellWord::Ungraded,
        }
    }

    /// Returns why the picture does not equal the reference: the cause of the difference, or the reason why the picture
    /// cannot be used.
    pub fn reason(&self) -> Option<String> {
        match self {
            Self::Different { cause, .. } => cause.as_ref().map(words),
            Self::Unusable(reason) => Some(reason.clone()),
            Self::Equal | Self::Missing | Self::Ungraded => None,
        }
    }
}

/// Describes a cause in a few words.
fn words(finding: &Finding) -> String {
    let mistakes = finding.mistakes();
    let mistakes = mistakes.trim_start();
    match finding {
        Finding::Equal { .. } => mistakes.to_owned(),
        Finding::Part { share, .. } => {
            format!("in part {mistakes}, {:.0}% of the wrong pixels", (100.0 * share).floor())
        }
        Finding::Rounding { rest } => rest.to_string(),
        Finding::Speckles { pixels, .. } => format!("epsilon too small: {pixels} scattered pixels"),
        Finding::Unknown { tried, .. } => format!("unknown ({tried} causes tried)"),
    }
}

impl Column {
    /// Creates a column for a picture without a reference. `problem` is the reason.
    pub fn ungraded(picture: String, problem: String, names: usize) -> Self {
        Self {
            picture,
            problem: Some(problem),
            cells: vec![Cell::Ungraded; names],
            found_as: vec![None; names],
        }
    }

    /// Returns the remarks on the cell in a row: the other name under which it was found, and why it differs.
    pub fn reason(&self, row: usize) -> Option<String> {
        let found_as = self.found_as.get(row).and_then(Option::as_ref);
        match (found_as.map(|file| format!("found as {file}")), self.cells[row].reason()) {
            (Some(found), Some(reason)) => Some(format!("{found}: {reason}")),
            (found, reason) => found.or(reason),
        }
    }

    /// Compares submissions with the reference, one after the other. Stops at the first error.
    ///
    /// `explain` receives the differing pictures without duplicates, and for each of them true if it fails. It returns a
    /// cause for each failed one that has one. It is called for each 64 MiB of pictures, which are then dropped. It is not
    /// called if all pictures are equal.
    pub fn graded<E>(
        picture: String,
        reference: &Picture,
        submissions: impl IntoIterator<Item = Result<Submission, E>>,
        tolerance: Tolerance,
        mut explain: impl FnMut(&[Picture], &[bool]) -> Vec<Option<Finding>>,
    ) -> Result<Self, E> {
        let (mut places, mut waiting) = (Vec::new(), Vec::new());
        let (mut comparisons, mut causes) = (Vec::new(), Vec::new());
        let mut settle = |waiting: &mut Vec<Picture>| {
            // All pictures have the reference's size.
            let compared = Comparison::of_each(waiting, reference).unwrap_or_default();
            let fails: Vec<bool> = compared.iter().map(|comparison| !tolerance.accepts(comparison)).collect();
            comparisons.extend(compared);
            let mut found = if waiting.is_empty() { Vec::new() } else { explain(waiting, &fails) };
            found.resize(waiting.len(), None);
            causes.append(&mut found);
            waiting.clear();
            comparisons.len()
        };
        let mut settled = 0;
        for submission in submissions {
            places.push(place(submission?, reference, &mut waiting, settled));
            if waiting.len() * reference.pixels().len() >= AT_ONCE {
                settled = settle(&mut waiting);
            }
        }
        settle(&mut waiting);
        let cell = |place| match place {
            Place::Decided(cell) => cell,
            Place::Wrong(picture) => {
                let comparison: &Comparison = &comparisons[picture];
                let passes = tolerance.accepts(comparison);
                Cell::Different {
                    passes,
                    comparison: Box::new(comparison.clone()),
                    cause: causes[picture].clone(),
                    picture,
                }
            }
        };
        let cells: Vec<Cell> = places.into_iter().map(cell).collect();
        let found_as = vec![None; cells.len()];
        Ok(Self { picture, problem: None, cells, found_as })
    }
}

/// The largest size in bytes of pictures held and explained at a time. A larger picture is held alone.
const AT_ONCE: usize = 1 << 26;

/// The state of a submission.
enum Place {
    Decided(Cell),
    /// The index of a picture that differs.
    Wrong(usize),
}

/// Adds a picture that differs from the reference to `waiting`, unless it is already there. `settled` is the number of
/// pictures before these.
fn place(submission: Submission, reference: &Picture, waiting: &mut Vec<Picture>, settled: usize) -> Place {
    match submission {
        Submission::Missing => Place::Decided(Cell::Missing),
        Submission::Unusable(reason) => Place::Decided(Cell::Unusable(reason)),
        Submission::Picture(picture) if picture == *reference => Place::Decided(Cell::Equal),
        Submission::Picture(picture) => {
            if let Err(error) = common_size(&picture, reference) {
                return Place::Decided(Cell::Unusable(error.message));
            }
            let at = waiting.iter().position(|other| *other == picture).unwrap_or_else(|| {
                waiting.push(picture);
                waiting.len() - 1
            });
            Place::Wrong(settled + at)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a picture of one pixel.
    fn picture(level: u8) -> Picture {
        Picture::from_rgb(1, 1, vec![level; 3])
    }

    #[test]
    fn a_picture_that_many_hand_in_is_compared_and_explained_once() {
        let handed_in = [5, 7, 5, 6, 0].map(|level| Submission::Picture(picture(level)));
        let large = Submission::Picture(Picture::new(2, 1).unwrap());
        let rest = [Submission::Missing, Submission::Unusable("why".into()), large];
        let tolerance = Tolerance { levels: 5, pixels: 0 };
        let explain = |wrong: &[Picture], fails: &[bool]| {
            assert_eq!((wrong, fails), (&[5, 7, 6].map(picture)[..], &[false, true, true][..]));
            vec![None, Some(Finding::Unknown { tried: 3, difference: None }), None]
        };
        let submissions = handed_in.into_iter().chain(rest).map(Ok::<_, ()>);
        let column = Column::graded("a".into(), &picture(0), submissions, tolerance, explain).unwrap();
        let verdicts: Vec<CellWord> = column.cells.iter().map(Cell::verdict).collect();
        use CellWord::{Failed, Missing, Passed, Unusable};
        assert_eq!(verdicts, [Passed, Failed, Passed, Failed, Passed, Missing, Unusable, Unusable]);
        let reasons: Vec<Option<String>> = column.cells.iter().map(Cell::reason).collect();
        assert_eq!(reasons[1].as_deref(), Some("unknown (3 causes tried)"));
        assert_eq!(reasons[6].as_deref(), Some("why"));
        assert!(reasons[7].as_deref().is_some_and(|reason| reason.ends_with("2 x 1 pixels against 1 x 1")));
        assert!(matches!(column.cells[2], Cell::Different { picture: 0, .. }));
    }

    #[test]
    fn nothing_is_explained_where_all_are_equal() {
        let submissions = [Submission::Picture(picture(1)), Submission::Missing].map(Ok::<_, ()>);
        let explain = |_: &[Picture], _: &[bool]| unreachable!();
        let column =
            Column::graded("a".into(), &picture(1), submissions, Tolerance::default(), explain).unwrap();
        assert!(matches!(column.cells[..], [Cell::Equal, Cell::Missing]));
    }

    #[test]
    fn large_pictures_are_held_one_at_a_time_and_an_error_ends_the_grading() {
        let large = |level: u8| Picture::from_rgb(4800, 4700, vec![level; 4800 * 4700 * 3]);
        let mut counts = vec![];
        let explain = |wrong: &[Picture], _: &[bool]| {
            counts.push(wrong.len());
            vec![Some(Finding::Unknown { tried: counts.len(), difference: None })]
        };
        let submissions = (1..4).map(|level| Ok::<_, ()>(Submission::Picture(large(level))));
        let column =
            Column::graded("a".into(), &large(0), submissions, Tolerance::default(), explain).unwrap();
        assert_eq!(counts, [1, 1, 1]);
        for (at, cell) in column.cells.iter().enumerate() {
            let Cell::Different { comparison, cause, picture, .. } = cell else { panic!("{cell:?}") };
            assert_eq!((*picture, cause), (at, &Some(Finding::Unknown { tried: at + 1, difference: None })));
            assert_eq!(comparison.largest.map(|largest| largest.levels), Some(at as u8 + 1));
        }
        let submissions = [Ok(Submission::Missing), Err("no memory"), Ok(Submission::Missing)];
        let found = Column::graded("a".into(), &picture(0), submissions, Tolerance::default(), |_, _| vec![]);
        assert_eq!(found.err(), Some("no memory"));
    }
}
