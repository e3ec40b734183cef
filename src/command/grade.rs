//! Grades a folder of pictures, and writes the page and the table of the results.

mod folder;
mod references;

use super::log::Log;
use super::outputs::{Outputs, prepare_report};
use super::progress::ProgressLine;
use super::signals::Signals;
use super::{End, Outcome, refused, threads};
use crate::base::escape::escape;
use crate::cli::{self, Grading};
use crate::diagnostic::Diagnostic;
use crate::image_io::check_distinct;
use crate::picture::Picture;
use crate::tools::grade::{Column, Page, Table, csv, summary};
use folder::{Folder, entries};
use references::{Reference, References};
use std::ops::ControlFlow;
use std::path::PathBuf;

/// Compares everything with its reference.
pub fn run(options: &Grading, signals: &Signals, log: &Log) -> Result<Outcome, End> {
    // The rows of the pictures are not known yet.
    threads::start(options.threads, 0)?;

    // List the pictures, and check that no file is lost.
    let listed = entries(&options.folder)?;
    let references = References::open(&options.references)?;
    let names: Vec<_> = references.names().collect();
    let folder = Folder::new(&options.folder, listed, &names)?;
    let written = options.report.clone().into_iter().flatten().chain(["-".into()]);
    let commands = match &options.references {
        cli::References::Commands(file) => Some(("list of commands", file.clone())),
        cli::References::Folder(_) => None,
    };
    let handed_in = folder.files().map(|file| ("picture", file));
    check_distinct(written, commands.into_iter().chain(references.files()).chain(handed_in))
        .map_err(refused)?;
    // A file that cannot be written is no reason to wait for the comparison.
    let files = options.report.as_ref().map(prepare_report).transpose()?;

    // Compare.
    let mut page = files.is_some().then(Page::default);
    let tolerance = options.tolerance.unwrap_or_default();
    let progress = ProgressLine::new(options.progress);
    let mut columns = Vec::with_capacity(names.len());
    for (index, name) in names.iter().enumerate() {
        let shown = name.to_string_lossy().into_owned();
        let text = format!("grading {} of {}: {}", index + 1, names.len(), escape(&shown));
        let watch = |_| {
            progress.show(|_| text.clone());
            ControlFlow::Continue(())
        };
        let _ = watch(());
        let compare = |reference: Result<Reference, String>| -> Result<Column, Diagnostic> {
            let reference = match reference {
                Ok(reference) => reference,
                Err(problem) => {
                    page.iter_mut().for_each(Page::add_ungraded);
                    return Ok(Column::ungraded(shown, problem, folder.names.len()));
                }
            };
            let picture = &reference.picture;
            page.iter_mut().for_each(|page| page.add_column(picture));
            // Only the page names causes.
            let explain = |different: &[Picture], fails: &[bool]| {
                let Some(page) = &mut page else { return Vec::new() };
                page.add_different(picture, different);
                let failed = different.iter().zip(fails).filter(|(_, fails)| **fails);
                let failed: Vec<Picture> = failed.map(|(picture, _)| picture.clone()).collect();
                let mut found = reference.explain(&failed).into_iter();
                fails.iter().map(|fails| if *fails { found.next() } else { None }).collect()
            };
            let submissions = folder.submissions(index, [picture.width(), picture.height()]);
            let mut column = Column::graded(shown, picture, submissions, tolerance, explain)?;
            let found_as = |file: &PathBuf| (file != name).then(|| file.to_string_lossy().into_owned());
            column.found_as = folder.taken[index].iter().map(found_as).collect();
            Ok(column)
        };
        let column = references.with(index, &|_| watch(()), compare)?;
        columns.push(column);
    }
    drop(progress);

    // Report.
    let problems = columns.iter().filter_map(|column| Some((&column.picture, column.problem.as_ref()?)));
    problems.for_each(|(name, problem)| {
        log.tell(Diagnostic::warning(format!("no reference for {}: {problem}", escape(name))));
    });
    if columns.iter().all(|column| column.problem.is_some()) {
        return Err(Diagnostic::error("there is no reference to grade by").into());
    }
    let shown = folder.names.iter().map(|name| name.to_string_lossy().into_owned()).collect();
    let table = Table { tolerance, names: shown, columns, notes: folder.notes };
    tell_other_names(&table, log);
    if let (None, Some(hint)) = (options.tolerance, table.tolerance_hint()) {
        log.tell(Diagnostic::note(hint));
    }
    if let (Some([page_file, values_file]), Some(page)) = (files, page) {
        let complete = vec![page_file.text(&page.finish(&table))?, values_file.text(&csv(&table))?];
        Outputs::new(complete, signals)?.name_all()?;
    }
    let written = options.report.clone().into_iter().flatten();
    let outcome = Outcome::new(summary(&table), written, options.progress);
    Ok(Outcome { passes: options.tolerance.is_none() || table.passes(), ..outcome })
}

/// Tells in a line for each name which of its pictures were found under other names.
fn tell_other_names(table: &Table, log: &Log) {
    for (row, name) in table.names.iter().enumerate() {
        let found = |column: &Column| Some((column.found_as[row].clone()?, column.picture.clone()));
        let others: Vec<(String, String)> = table.columns.iter().filter_map(found).collect();
        if let Some((file, picture)) = others.first() {
            let (name, file, picture) = (escape(name), escape(file), escape(picture));
            let more =
                if others.len() > 1 { format!(", and {} more", others.len() - 1) } else { String::new() };
            log.tell(Diagnostic::note(format!("{name}: graded {file} as {picture}{more}")));
        }
    }
}
