//! One picture, as submitted by all names.

use super::page::Page;
use super::reference::{Reference, Rule, Verdict};
use crate::diagnostic::Diagnostic;
use crate::picture::{FloatPicture, Pixels};
use crate::tools::causes::Finding;
use crate::tools::compare::{Difference, relation};

#[derive(Clone, Debug)]
pub enum Submission {
    Picture(Pixels),
    /// No file.
    Missing,
    /// A file that is not a picture, and the reason.
    Unusable(String),
}

/// One picture, as submitted by all names.
#[derive(Clone, Debug)]
pub struct Column {
    /// Its name.
    pub picture: String,
    /// The reason why there is no reference, if there is none.
    pub problem: Option<String>,
    /// True if the reference is a picture of numbers.
    pub has_numbers: bool,
    /// The results, one for each name.
    pub cells: Vec<Cell>,
    /// Remarks on the files, one for each name.
    pub remarks: Vec<Remark>,
}

/// A remark on the files of a picture of one name.
#[derive(Clone, Debug, Default)]
pub struct Remark {
    /// The path of the file used, if it differs from the picture's name.
    pub found_as: Option<String>,
    /// The files that are not used but may be meant for the picture, and why not.
    pub others: Option<String>,
}

/// The result of one picture of one name.
#[derive(Clone, Debug)]
pub enum Cell {
    Equal,
    Different {
        difference: Difference,
        verdict: Verdict,
        /// The cause, if one was searched for and found.
        cause: Option<Box<Finding>>,
        /// Its index among the different pictures of the column.
        picture: usize,
    },
    Missing,
    /// There is no readable picture of the reference's size. Contains the reason.
    Unusable(String),
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
    pub fn word(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Failed => "failed",
            Self::Missing => "missing",
            Self::Unusable => "unusable",
            Self::Ungraded => "no reference",
        }
    }

    /// Returns the class of a cell in a page.
    pub fn class(self) -> &'static str {
        if self == Self::Ungraded { "ungraded" } else { self.word() }
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
            Self::Different { verdict: Verdict { passes: false, .. }, .. } => CellWord::Failed,
            Self::Equal | Self::Different { .. } => CellWord::Passed,
            Self::Missing => CellWord::Missing,
            Self::Unusable(_) => CellWord::Unusable,
            Self::Ungraded => CellWord::Ungraded,
        }
    }

    /// Returns the number of differing pixels of a picture that passes since rounding explains them.
    pub fn rounded(&self) -> Option<u64> {
        match self {
            Self::Different {
                verdict: Verdict { passes: true, unexplained: Some(_) }, difference, ..
            } => Some(difference.pixels_that_differ()),
            _ => None,
        }
    }

    /// Returns why the picture does not equal the reference: rounding, the cause of the difference, or the reason why the
    /// picture cannot be used.
    pub fn reason(&self) -> Option<String> {
        match self {
            Self::Different {
                difference,
                verdict: Verdict { passes: true, unexplained: Some(left) },
                ..
            } => {
                let rest =
                    if *left > 0 { format!(", and {left} that it does not explain") } else { String::new() };
                Some(format!("rounding, {} pixels{rest}", difference.pixels_that_differ() - left))
            }
            Self::Different { cause, .. } => cause.as_deref().map(words),
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
        Finding::Unknown { tried, difference: None } => format!("unknown ({tried} causes tried)"),
        Finding::Unknown { difference: Some(kind), .. } => format!("unknown: {kind}"),
        found => found.to_string(),
    }
}

impl Column {
    /// Creates a column for a picture without a reference. `problem` is the reason.
    pub fn ungraded(picture: String, problem: String, names: usize) -> Self {
        Self {
            picture,
            problem: Some(problem),
            has_numbers: false,
            cells: vec![Cell::Ungraded; names],
            remarks: vec![Remark::default(); names],
        }
    }

    /// Returns the remarks on the cell in a row: on its file, and why it differs.
    pub fn reason(&self, row: usize) -> Option<String> {
        let (cell, Remark { found_as, others }) = (&self.cells[row], &self.remarks[row]);
        let found_as = found_as.as_ref().map(|file| format!("found as {file}"));
        let others = others.as_ref().filter(|_| cell.verdict() != CellWord::Passed);
        let others = others.map(|others| format!("perhaps {others}"));
        let all: Vec<String> = found_as.into_iter().chain(cell.reason()).chain(others).collect();
        (!all.is_empty()).then(|| all.join(": "))
    }
}

/// The largest size in bytes of pictures held and explained at a time. A larger picture is held alone.
const AT_ONCE: usize = 1 << 26;

/// Grades one picture of all names, one after the other.
pub struct ColumnGrader<'g, 'r> {
    reference: &'g Reference<'r>,
    rule: Rule,
    finds_causes: bool,
    page: Option<&'g mut Page>,
    places: Vec<Place>,
    /// The results of different pictures.
    judged: Vec<Cell>,
    /// Different pictures that are not judged yet, each once.
    waiting: Vec<Pixels>,
}

/// The state of a submission.
enum Place {
    Decided(Cell),
    /// The index of a picture that differs.
    Judged(usize),
}

impl<'g, 'r> ColumnGrader<'g, 'r> {
    /// Begins a column, also of the page.
    pub fn new(
        reference: &'g Reference<'r>,
        rule: Rule,
        finds_causes: bool,
        page: Option<&'g mut Page>,
    ) -> Result<Self, Diagnostic> {
        let mut grader =
            Self { reference, rule, finds_causes, page, places: vec![], judged: vec![], waiting: vec![] };
        if let Some(page) = &mut grader.page {
            page.add_column(reference)?;
        }
        Ok(grader)
    }

    /// Takes the submission of the next name.
    pub fn add(&mut self, submission: Submission) -> Result<(), Diagnostic> {
        let own = &self.reference.pixels;
        let place = match submission {
            Submission::Missing => Place::Decided(Cell::Missing),
            Submission::Unusable(reason) => Place::Decided(Cell::Unusable(reason)),
            Submission::Picture(picture) if picture == *own => Place::Decided(Cell::Equal),
            Submission::Picture(picture) if picture.size() != own.size() => {
                Place::Decided(Cell::Unusable(other_size(picture.size(), own.size())))
            }
            Submission::Picture(picture) => {
                let at = self.waiting.iter().position(|other| *other == picture).unwrap_or_else(|| {
                    self.waiting.push(picture);
                    self.waiting.len() - 1
                });
                Place::Judged(self.judged.len() + at)
            }
        };
        self.places.push(place);
        if self.waiting.iter().map(bytes).sum::<usize>() >= AT_ONCE { self.judge() } else { Ok(()) }
    }

    /// Judges the waiting pictures, and drops them.
    fn judge(&mut self) -> Result<(), Diagnostic> {
        let reference = self.reference;
        let waiting = std::mem::take(&mut self.waiting);
        let differences = Difference::of_each(&waiting, &reference.pixels)?;
        for (pixels, difference) in waiting.iter().zip(differences) {
            let verdict = reference.judge(self.rule, pixels, &difference);
            let is_explained = self.finds_causes && !verdict.passes;
            let cause = if is_explained { reference.explain(pixels).map(Box::new) } else { None };
            let picture = self.judged.len();
            self.judged.push(match difference.pixels_that_differ() {
                // A NaN differs from itself for the comparison of pictures by `==`.
                0 => Cell::Equal,
                _ => Cell::Different { difference, verdict, cause, picture },
            });
        }
        if let Some(page) = &mut self.page {
            page.add_different(reference, &waiting)?;
        }
        Ok(())
    }

    /// Returns the column of this picture.
    pub fn finish(mut self, picture: String, remarks: Vec<Remark>) -> Result<Column, Diagnostic> {
        self.judge()?;
        let cells = self.places.into_iter().map(|place| match place {
            Place::Decided(cell) => cell,
            Place::Judged(picture) => self.judged[picture].clone(),
        });
        let has_numbers = matches!(self.reference.pixels, Pixels::Numbers(_));
        Ok(Column { picture, problem: None, has_numbers, cells: cells.collect(), remarks })
    }
}

/// Returns about how many bytes a picture takes.
fn bytes(picture: &Pixels) -> usize {
    match picture {
        Pixels::Bytes(picture) => picture.pixels().len(),
        Pixels::Numbers(FloatPicture { colors, .. }) => size_of_val(colors.as_slice()),
    }
}

/// Returns why a picture of another size cannot be compared.
fn other_size(own @ [width, height]: [usize; 2], right @ [right_width, right_height]: [usize; 2]) -> String {
    let relation = relation(own, right).map_or(String::new(), |is| format!(": it {is}"));
    format!("its size is {width} x {height} pixels instead of {right_width} x {right_height}{relation}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Picture;

    const EXACT: Rule = Rule::Equal;

    #[test]
    #[ignore = "slow: a quarter of a minute"]
    fn large_pictures_are_held_one_at_a_time() {
        let large = |level: u8| Pixels::Bytes(Picture::from_rgb(4800, 4700, vec![level; 4800 * 4700 * 3]));
        let reference = Reference::of_file(large(0));
        let mut grader = ColumnGrader::new(&reference, EXACT, false, None).unwrap();
        for level in 1..4 {
            grader.add(Submission::Picture(large(level))).unwrap();
            assert!(grader.waiting.is_empty());
        }
        let column = grader.finish("a".into(), vec![Remark::default(); 3]).unwrap();
        let largest = column.cells.iter().map(|cell| match cell {
            Cell::Different { difference, .. } => difference.largest(),
            other => panic!("{other:?}"),
        });
        assert!(largest.eq([1.0, 2.0, 3.0]));
    }
}
