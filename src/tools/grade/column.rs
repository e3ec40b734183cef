//! One picture of all names.

use crate::picture::Picture;
use crate::tools::causes::Finding;
use crate::tools::compare::{CompareError, Comparison, Tolerance};
use std::fmt::Write;

/// What was handed in.
#[derive(Clone, Debug)]
pub enum Submission {
    /// A picture of the reference's size.
    Picture(Picture),
    /// There is none.
    Missing,
    /// A file that is no such picture, and why.
    Unusable(String),
}

/// One picture of all names.
#[derive(Clone, Debug)]
pub struct Column {
    /// The name of the picture.
    pub picture: String,
    /// Why there is no reference, if there is none.
    pub problem: Option<String>,
    /// One for each name.
    pub cells: Vec<Cell>,
    /// For each name, the path of the file that was taken, if it is not the picture's name.
    pub found_as: Vec<Option<String>>,
}

/// One picture of one name.
#[derive(Clone, Debug)]
pub enum Cell {
    /// It equals the reference.
    Equal,
    /// It differs from the reference.
    Different {
        /// How far.
        comparison: Box<Comparison>,
        /// Whether the tolerance accepts it.
        passes: bool,
        /// Why, if that was looked for.
        cause: Option<Finding>,
        /// Its index among the different pictures of the column.
        picture: usize,
    },
    /// There is no picture.
    Missing,
    /// There is no readable picture of the reference's size, and why.
    Unusable(String),
    /// There is no reference.
    Ungraded,
}

/// What a cell says, in a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellWord {
    /// The picture is right.
    Passed,
    /// The picture is wrong.
    Failed,
    /// There is no picture.
    Missing,
    /// The picture cannot be read or compared.
    Unusable,
    /// The picture has no reference.
    Ungraded,
}

impl CellWord {
    /// The word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Failed => "failed",
            Self::Missing => "missing",
            Self::Unusable => "unusable",
            Self::Ungraded => "no reference",
        }
    }

    /// The mark of a cell in a page.
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
    /// What it says, in a word.
    pub fn verdict(&self) -> CellWord {
        match self {
            Self::Equal | Self::Different { passes: true, .. } => CellWord::Passed,
            Self::Different { passes: false, .. } => CellWord::Failed,
            Self::Missing => CellWord::Missing,
            Self::Unusable(_) => CellWord::Unusable,
            Self::Ungraded => CellWord::Ungraded,
        }
    }

    /// Why it is not the reference: the cause of the difference, or of the failure to read the picture.
    pub fn reason(&self) -> Option<String> {
        match self {
            Self::Different { cause, .. } => cause.as_ref().map(words),
            Self::Unusable(reason) => Some(reason.clone()),
            Self::Equal | Self::Missing | Self::Ungraded => None,
        }
    }
}

/// A cause in a few words.
fn words(finding: &Finding) -> String {
    let mut words = String::new();
    // Writing to a string cannot fail.
    let _ = match finding {
        Finding::Equal { cause, .. } => write!(words, "{}", cause.to_string().trim_start()),
        Finding::Part { cause, share } => {
            write!(
                words,
                "at least {}, {:.0}% of the error",
                cause.to_string().trim_start(),
                (100.0 * share).floor()
            )
        }
        Finding::Speckles { pixels, .. } => write!(words, "epsilon too small: {pixels} scattered pixels"),
        Finding::Unknown { tried } => write!(words, "unknown ({tried} causes tried)"),
    };
    words
}

impl Column {
    /// A picture that nothing can be compared with, and why.
    pub fn ungraded(picture: String, problem: String, names: usize) -> Self {
        Self {
            picture,
            problem: Some(problem),
            cells: vec![Cell::Ungraded; names],
            found_as: vec![None; names],
        }
    }

    /// What is to be said of the cell in a row: under which other name it was found, and why it is not the reference.
    pub fn reason(&self, row: usize) -> Option<String> {
        let found_as = self.found_as.get(row).and_then(Option::as_ref);
        match (found_as.map(|file| format!("found as {file}")), self.cells[row].reason()) {
            (Some(found), Some(reason)) => Some(format!("{found}: {reason}")),
            (found, reason) => found.or(reason),
        }
    }

    /// Compares what was handed in with the reference.
    ///
    /// `explain` is given the pictures that differ, without repetitions, and returns a cause for each that has one. It
    /// is not called if all are equal. Returns the column and these pictures.
    pub fn graded(
        picture: String,
        reference: &Picture,
        submissions: Vec<Submission>,
        tolerance: Tolerance,
        explain: impl FnOnce(&[Picture]) -> Vec<Option<Finding>>,
    ) -> (Self, Vec<Picture>) {
        let mut wrong = Vec::new();
        let places: Vec<Place> =
            submissions.into_iter().map(|submission| place(submission, reference, &mut wrong)).collect();
        // All are of the reference's size.
        let comparisons = Comparison::of_each(&wrong, reference).unwrap_or_default();
        let causes = if wrong.is_empty() { Vec::new() } else { explain(&wrong) };
        let cell = |place| match place {
            Place::Decided(cell) => cell,
            Place::Wrong(picture) => Cell::Different {
                passes: tolerance.accepts(&comparisons[picture]),
                comparison: Box::new(comparisons[picture].clone()),
                cause: causes.get(picture).copied().flatten(),
                picture,
            },
        };
        let cells: Vec<Cell> = places.into_iter().map(cell).collect();
        let found_as = vec![None; cells.len()];
        (Self { picture, problem: None, cells, found_as }, wrong)
    }
}

/// What becomes of a submission.
enum Place {
    Decided(Cell),
    /// A picture that differs, by its index.
    Wrong(usize),
}

/// Adds a picture that differs from the reference to the wrong ones, unless it is among them.
fn place(submission: Submission, reference: &Picture, wrong: &mut Vec<Picture>) -> Place {
    match submission {
        Submission::Missing => Place::Decided(Cell::Missing),
        Submission::Unusable(reason) => Place::Decided(Cell::Unusable(reason)),
        Submission::Picture(picture) if picture == *reference => Place::Decided(Cell::Equal),
        Submission::Picture(picture) if size(&picture) != size(reference) => {
            let sizes = CompareError::Sizes { a: size(&picture), b: size(reference) };
            Place::Decided(Cell::Unusable(sizes.to_string()))
        }
        Submission::Picture(picture) => {
            Place::Wrong(wrong.iter().position(|other| *other == picture).unwrap_or_else(|| {
                wrong.push(picture);
                wrong.len() - 1
            }))
        }
    }
}

fn size(picture: &Picture) -> [u32; 2] {
    [picture.width(), picture.height()]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One pixel.
    fn picture(level: u8) -> Picture {
        Picture::from_rgb(1, 1, vec![level; 3])
    }

    #[test]
    fn a_picture_that_many_hand_in_is_compared_and_explained_once() {
        let handed_in = [5, 7, 5, 6, 0].map(|level| Submission::Picture(picture(level)));
        let large = Submission::Picture(Picture::new(2, 1).unwrap());
        let rest = [Submission::Missing, Submission::Unusable("why".into()), large];
        let tolerance = Tolerance { levels: 5, pixels: 0 };
        let explain = |wrong: &[Picture]| {
            assert_eq!(wrong, [5, 7, 6].map(picture));
            vec![None, Some(Finding::Unknown { tried: 3 }), None]
        };
        let submissions = handed_in.into_iter().chain(rest).collect();
        let (column, wrong) = Column::graded("a".into(), &picture(0), submissions, tolerance, explain);
        assert_eq!(wrong.len(), 3);
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
        let submissions = vec![Submission::Picture(picture(1)), Submission::Missing];
        let explain = |_: &[Picture]| unreachable!();
        let (column, _) = Column::graded("a".into(), &picture(1), submissions, Tolerance::default(), explain);
        assert!(matches!(column.cells[..], [Cell::Equal, Cell::Missing]));
    }
}
