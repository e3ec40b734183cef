//! Grades a folder of pictures, and writes the page and the table of the results.

mod folder;
mod references;

use super::complete_files::CompleteFiles;
use super::log::Log;
use super::progress::ProgressLine;
use super::signals::Signals;
use super::{End, Outcome, refused, threads};
use folder::Folder;
use raytracer::base::escape::escape;
use raytracer::cli;
use raytracer::cli::Grading;
use raytracer::diagnostic::Diagnostic;
use raytracer::image_io::{OutputFile, Written, check_distinct};
use raytracer::tools::compare::Tolerance;
use raytracer::tools::grade::{Column, Page, Table, csv, summary};
use references::{Reference, References};
use std::ffi::OsStr;
use std::path::PathBuf;

/// Compares everything with its reference.
pub fn run(options: &Grading, signals: &Signals, log: &Log) -> Result<Outcome, End> {
    // The rows of the pictures are not known yet.
    threads::start(options.threads, 0)?;
    let folder = Folder::open(&options.folder)?;
    let references = References::open(&options.references)?;
    let report = options.report_files();
    let written = report.into_iter().flatten().chain(["-".into()]).map(Written::Named);
    let commands = match &options.references {
        cli::References::Commands(file) => Some(("list of commands", file.clone())),
        cli::References::Folder(_) => None,
    };
    let submitted = references.names().flat_map(|name| folder.files(name, &references));
    let submitted = submitted.map(|file| ("picture", file));
    check_distinct(written, commands.into_iter().chain(references.files()).chain(submitted))
        .map_err(refused)?;
    // A file that cannot be written is no reason to wait for the comparison.
    let files = options.report_files().map(prepare).transpose()?;

    let page = files.is_some().then(Page::default);
    let mut grader = Grader {
        folder: &folder,
        references: &references,
        tolerance: options.tolerance.unwrap_or_default(),
        page,
    };
    let progress = ProgressLine::new(options.progress);
    let mut columns = Vec::with_capacity(references.len());
    for (index, name) in references.names().enumerate() {
        let (number, all, name_shown) = (index + 1, references.len(), escape(&name.to_string_lossy()));
        progress.show(|_| format!("grading {number} of {all}: {name_shown}"));
        columns.push(references.with(index, |reference| grader.column(name, reference))?);
    }
    progress.end();

    let problems = columns.iter().filter_map(|column| Some((&column.picture, column.problem.as_ref()?)));
    problems.for_each(|(name, problem)| {
        log.tell(Diagnostic::warning(format!("no reference for {}: {problem}", escape(name))));
    });
    if columns.iter().all(|column| column.problem.is_some()) {
        return Err(Diagnostic::error("there is no reference to grade by").into());
    }
    let notes = folder.notes(&references, &columns);
    let table = Table { tolerance: grader.tolerance, names: folder.shown_names(), columns, notes };
    tell_other_names(&table, log);
    if let (None, Some(hint)) = (options.tolerance, table.tolerance_hint()) {
        log.tell(Diagnostic::note(hint));
    }
    if let (Some([page, values]), Some(shown)) = (files, grader.page) {
        let complete = CompleteFiles::default();
        complete.add(page.text(&shown.finish(&table))?)?;
        complete.add(values.text(&csv(&table))?)?;
        complete.finish(signals)?;
    }
    let written = options.report_files().into_iter().flatten();
    let outcome = Outcome::of_text(summary(&table)).tell_of(written, options.progress);
    Ok(Outcome { passes: options.tolerance.is_none() || table.passes(), ..outcome })
}

/// Tells whose pictures were found under other names, in a line for each name.
fn tell_other_names(table: &Table, log: &Log) {
    for (row, name) in table.names.iter().enumerate() {
        let others: Vec<(&str, &str)> = table
            .columns
            .iter()
            .filter_map(|column| Some((column.found_as[row].as_deref()?, column.picture.as_str())))
            .collect();
        if let Some((file, picture)) = others.first() {
            let (name, file, picture) = (escape(name), escape(file), escape(picture));
            let more =
                if others.len() > 1 { format!(", and {} more", others.len() - 1) } else { String::new() };
            log.tell(Diagnostic::note(format!("{name}: {file} is taken for {picture}{more}")));
        }
    }
}

/// The files of the page and of the table beside it.
fn prepare(files: [PathBuf; 2]) -> Result<[OutputFile; 2], Diagnostic> {
    let [page, values] = files.map(|file| OutputFile::prepare(&file));
    Ok([page?, values?])
}

/// Compares one picture of all names after the other.
struct Grader<'f> {
    folder: &'f Folder,
    references: &'f References,
    tolerance: Tolerance,
    /// If one is wanted.
    page: Option<Page>,
}

impl Grader<'_> {
    fn column(&mut self, name: &OsStr, reference: Result<Reference, String>) -> Result<Column, Diagnostic> {
        let shown = name.to_string_lossy().into_owned();
        match reference {
            Ok(reference) => self.graded(name, shown, reference),
            Err(problem) => {
                self.page.iter_mut().for_each(Page::add_ungraded);
                Ok(Column::ungraded(shown, problem, self.folder.len()))
            }
        }
    }

    fn graded(&mut self, name: &OsStr, shown: String, reference: Reference) -> Result<Column, Diagnostic> {
        let Reference { picture, mut source } = reference;
        let taken = self.folder.taken(name, self.references);
        let submissions = self.folder.submissions(&taken, [picture.width(), picture.height()]);
        let mut page = self.page.as_mut();
        page.iter_mut().for_each(|page| page.add_column(&picture));
        // Causes stand in the report alone.
        let explain = |wrong: &[_]| match &mut page {
            Some(page) => {
                page.add_different(&picture, wrong);
                source.explain(wrong, &picture)
            }
            None => Vec::new(),
        };
        let mut column = Column::graded(shown, &picture, submissions, self.tolerance, explain)?;
        let found_as = |file: &PathBuf| (file != name).then(|| file.to_string_lossy().into_owned());
        column.found_as = taken.iter().map(found_as).collect();
        Ok(column)
    }
}
