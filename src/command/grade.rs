//! Grades a folder of pictures, and writes the page, the table and the document of the results.

mod folder;
mod references;

use super::log::Log;
use super::outputs::{Outputs, prepare_report};
use super::progress::ProgressLine;
use super::report::FORMAT;
use super::signals::Signals;
use super::{End, Outcome, refused, threads};
use crate::base::escape::escape;
use crate::base::stdio::{STDIO, is_stdio};
use crate::cli::{self, Grading};
use crate::diagnostic::Diagnostic;
use crate::image_io::{OutputFile, check_distinct};
use crate::tools::grade::{Column, ColumnGrader, Page, Rule, Table, csv, document, summary};
use folder::{Folder, entries};
use references::References;
use std::ffi::OsStr;
use std::ops::ControlFlow;
use std::path::PathBuf;

/// Compares everything with its reference.
pub fn run(options: &Grading, signals: &Signals, log: &Log) -> Result<Outcome, End> {
    // The rows of the pictures are not known yet.
    threads::start(options.threads, 0)?;

    // List the pictures, and check that no file is lost.
    let listed = entries(&options.folder)?;
    let references = References::open(&options.references)?;
    let wanted = references.names().map(OsStr::to_owned).collect();
    let folder = Folder::new(&options.folder, listed, wanted, options.student.as_deref())?;
    check_files(options, &references, &folder)?;
    // A file that cannot be written is no reason to wait for the comparison.
    let report = options.report.as_ref().map(prepare_report).transpose()?;
    let json = options.json.as_deref().map(OutputFile::prepare).transpose()?;

    // Compare.
    let rule = match (options.tolerance, &options.references) {
        (Some(tolerance), _) => Rule::Tolerance(tolerance),
        (None, cli::References::Commands(_)) => Rule::Rounding,
        (None, cli::References::Folder(_)) => Rule::Equal,
    };
    let mut class = Class {
        references: &references,
        folder: &folder,
        rule,
        // Only the documents name causes.
        finds_causes: report.is_some() || json.is_some(),
        page: report.is_some().then(Page::default),
        progress: ProgressLine::new(options.progress),
    };
    let columns = (0..folder.wanted.len()).map(|index| class.column(index));
    let columns = columns.collect::<Result<Vec<Column>, Diagnostic>>()?;
    let page = class.page;
    drop(class.progress);

    // Report.
    for column in &columns {
        if let Some(problem) = &column.problem {
            let name = escape(&column.picture);
            log.log(Diagnostic::warning(format!("no reference for {name}: {problem}")));
        }
    }
    if columns.iter().all(|column| column.problem.is_some()) {
        return Err(Diagnostic::error("there is no reference to grade by").into());
    }
    tell_other_names(&folder, &columns, log);
    let shown = folder.names.iter().map(|name| name.to_string_lossy().into_owned()).collect();
    let table = Table { rule, names: shown, columns, not_graded: folder.not_graded().cloned().collect() };
    let mut complete = vec![];
    if let (Some([page_file, values_file]), Some(page)) = (report, page) {
        complete.push(page_file.text(&page.finish(&table))?);
        complete.push(values_file.text(&csv(&table))?);
    }
    if let Some(file) = json {
        complete.push(file.text(&document(&table, FORMAT))?);
    }
    Outputs::new(complete, signals)?.name_all()?;
    let text = if prints_json(options) { String::new() } else { summary(&table) };
    let outcome = Outcome::new(text, written(options), options.progress);
    Ok(Outcome { passes: options.tolerance.is_none() || table.passes(), ..outcome })
}

/// Refuses to write a file twice, or one that is read.
fn check_files(options: &Grading, references: &References, folder: &Folder) -> Result<(), End> {
    let commands = match &options.references {
        cli::References::Commands(file) => Some(("list of commands", file.clone())),
        cli::References::Folder(_) => None,
    };
    let handed_in = folder.files().map(|file| ("picture", file));
    let printed = (!prints_json(options)).then(|| STDIO.into());
    let read = commands.into_iter().chain(references.files()).chain(handed_in);
    check_distinct(written(options).chain(printed), read).map_err(refused)
}

fn written(options: &Grading) -> impl Iterator<Item = PathBuf> {
    options.report.iter().flatten().chain(&options.json).cloned()
}

/// Returns true if the document is printed in place of the text.
fn prints_json(options: &Grading) -> bool {
    options.json.as_deref().is_some_and(is_stdio)
}

/// The pictures of all names.
struct Class<'c> {
    references: &'c References,
    folder: &'c Folder,
    rule: Rule,
    finds_causes: bool,
    page: Option<Page>,
    progress: ProgressLine,
}

impl Class<'_> {
    /// Grades one picture of all names.
    fn column(&mut self, index: usize) -> Result<Column, Diagnostic> {
        let (folder, progress) = (self.folder, &self.progress);
        let shown = folder.wanted[index].to_string_lossy().into_owned();
        let count = folder.wanted.len();
        let text = format!("grading {} of {count}: {}", index + 1, escape(&shown));
        let show = || progress.show(|_| text.clone());
        let watch = |_| {
            show();
            ControlFlow::Continue(())
        };
        show();
        let opened = self.references.open_one(index);
        let reference = match opened.as_ref().map_err(Diagnostic::clone).and_then(|it| it.reference(&watch)) {
            Ok(reference) => reference,
            Err(error) => {
                self.page.iter_mut().for_each(Page::add_ungraded);
                // In one line.
                let problem = if error.places.is_empty() { error.in_one_line() } else { error.headline() };
                return Ok(Column::ungraded(shown, problem, folder.names.len()));
            }
        };
        let page = self.page.as_mut();
        let mut grader = ColumnGrader::new(&reference, self.rule, self.finds_causes, page)?;
        let mut remarks = vec![];
        for row in 0..folder.names.len() {
            grader.add(folder.submission(row, index, reference.pixels.size())?)?;
            remarks.push(folder.remark(row, index));
        }
        grader.finish(shown, remarks)
    }
}

/// Tells in a line for each name which of its graded pictures were found under other names.
fn tell_other_names<'c>(folder: &Folder, columns: &'c [Column], log: &Log) {
    for (row, name) in folder.names.iter().enumerate() {
        let other = |column: &'c Column| Some((column.remarks[row].found_as.as_ref()?, &column.picture));
        let mut others = columns.iter().filter_map(other);
        let Some((file, picture)) = others.next() else { continue };
        let more = match others.count() {
            0 => String::new(),
            count => format!(", and {count} more"),
        };
        let name = escape(&name.to_string_lossy());
        log.log(Diagnostic::note(format!("{name}: graded {} as {}{more}", escape(file), escape(picture))));
    }
}
