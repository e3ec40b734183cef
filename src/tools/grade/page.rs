//! The page of a grading: one file, without anything from elsewhere.

use super::{Cell, CellWord, Column, Score, Table};
use crate::escape::html;
use crate::image_io::embedded::{Embedded, file, thumbnail_file};
use crate::picture::Picture;
use crate::tools::compare::{Comparison, Tolerance};
use rayon::prelude::*;

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// Only what stands in the page itself is shown and run.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'; base-uri 'none'";

/// A page under construction, which takes one column after the other.
#[derive(Debug, Default)]
pub struct Page {
    thumbnails: Embedded,
    /// Those that a click shows.
    pictures: Embedded,
    columns: Vec<Shown>,
}

/// The pictures of a column, by their indices.
#[derive(Debug, Default)]
struct Shown {
    /// The thumbnail of the reference.
    thumbnail: Option<usize>,
    /// The reference, if any picture differs from it.
    reference: Option<usize>,
    /// The thumbnail of each different picture, and the picture.
    different: Vec<[usize; 2]>,
}

impl Page {
    /// Adds a column that has a reference, with the pictures that differ from it.
    pub fn add(&mut self, reference: &Picture, different: &[Picture]) {
        let files: Vec<[String; 2]> =
            different.par_iter().map(|picture| [thumbnail_file(picture), file(picture)]).collect();
        let shown = Shown {
            thumbnail: Some(self.thumbnails.add(thumbnail_file(reference))),
            reference: (!files.is_empty()).then(|| self.pictures.add(file(reference))),
            different: files
                .into_iter()
                .map(|[small, whole]| [self.thumbnails.add(small), self.pictures.add(whole)])
                .collect(),
        };
        self.columns.push(shown);
    }

    /// Adds a column without a reference.
    pub fn add_ungraded(&mut self) {
        self.columns.push(Shown::default());
    }

    /// The page of a table with the columns that were added.
    pub fn finish(&self, table: &Table) -> String {
        let thumbnails = self.thumbnails.files().into_iter().enumerate();
        let thumbnails: String = thumbnails
            .map(|(index, file)| format!(".t{index}{{background-image:url(data:image/png;base64,{file})}}\n"))
            .collect();
        let pictures = self.pictures.files().join("\",\"");
        let pictures = if pictures.is_empty() { pictures } else { format!("\"{pictures}\"") };
        let head = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
             <meta name=\"viewport\" content=\"width=device-width\">\n<title>Pictures graded</title>\n\
             <style>\n{STYLE}{thumbnails}</style>\n</head>\n"
        );
        let (summary, rows, notes) = (summary(table), self.rows(table), notes(table));
        format!(
            "{head}<body>\n{summary}<main><table>\n{}{rows}</table></main>\n{notes}{DIALOG}\
             <script type=\"application/json\" id=\"pictures\">[{pictures}]</script>\n\
             <script>\n{SCRIPT}</script>\n</body>\n</html>\n",
            self.header(table)
        )
    }

    fn header(&self, table: &Table) -> String {
        let columns = table.columns.iter().zip(&self.columns);
        let cells: String = columns
            .map(|(column, shown)| {
                let name = html(&column.picture);
                let result = match &column.problem {
                    None => Score::of(&column.cells).to_string(),
                    Some(problem) => format!("<em>no reference: {}</em>", html(problem)),
                };
                format!(
                    "<th scope=\"col\">{}{name}<small>{result}</small></th>\n",
                    thumbnail(shown.thumbnail)
                )
            })
            .collect();
        format!("<thead><tr><td></td>\n{cells}</tr></thead>\n")
    }

    fn rows(&self, table: &Table) -> String {
        let row = |(row, name): (usize, &String)| {
            let columns = table.columns.iter().zip(&self.columns);
            let cells: String = columns.map(|(column, shown)| cell(column, row, shown)).collect();
            let (name, score) = (html(name), table.score_of_row(row));
            format!("<tr><th scope=\"row\">{name}<small>{score}</small></th>\n{cells}</tr>\n")
        };
        table.names.iter().enumerate().map(row).collect()
    }
}

/// Where a click shows the pictures of a cell.
const DIALOG: &str = "<dialog><form method=\"dialog\"><button>Close</button></form><h2></h2><p></p><div>\
    <figure><canvas></canvas><figcaption>A: handed in</figcaption></figure>\
    <figure><canvas></canvas><figcaption>B: the reference</figcaption></figure>\
    <figure><canvas></canvas><figcaption></figcaption></figure>\
    <figure><canvas></canvas><figcaption></figcaption><button type=\"button\">Stop</button></figure>\
    </div></dialog>\n";

fn summary(table: &Table) -> String {
    let score = table.score();
    let (passed, graded) = (score.passed, score.graded());
    let (names, pictures) = (table.names.len(), table.columns.len());
    let condition = match table.tolerance {
        Tolerance { levels: 0, pixels: 0 } => "it equals the reference".to_owned(),
        Tolerance { levels, pixels } => {
            format!("at most {pixels} of its pixels differ from the reference by more than {levels} levels")
        }
    };
    format!(
        "<header><h1>{passed} of {graded} pictures pass</h1>\n<p>Names: {names}. Pictures: {pictures}. A picture passes \
         if {condition}. A cause is judged by the part of a picture where many pixels differ. A click on a picture \
         that differs shows it beside the reference.</p></header>\n"
    )
}

fn notes(table: &Table) -> String {
    if table.notes.is_empty() {
        return String::new();
    }
    let items: String = table.notes.iter().map(|note| format!("<li>{}</li>\n", html(note))).collect();
    let count = table.notes.len();
    format!("<details><summary>Not graded: {count}</summary><ul>\n{items}</ul></details>\n")
}

fn thumbnail(index: Option<usize>) -> String {
    index.map_or(String::new(), |index| format!("<i class=\"t{index}\"></i>"))
}

fn cell(column: &Column, row: usize, shown: &Shown) -> String {
    let cell = &column.cells[row];
    let (class, mark) = match cell.verdict() {
        CellWord::Passed => ("passed", "\u{2713}"),
        CellWord::Failed => ("failed", "\u{2717}"),
        CellWord::Missing => ("missing", "\u{2013} missing"),
        CellWord::Unusable => ("unusable", "! unusable"),
        CellWord::Ungraded => ("ungraded", "?"),
    };
    let reason =
        column.reason(row).map_or(String::new(), |reason| format!("<small>{}</small>", html(&reason)));
    match cell {
        Cell::Equal => {
            format!("<td class=\"{class}\">{}<b>{mark}</b>{reason}</td>\n", thumbnail(shown.thumbnail))
        }
        Cell::Different { comparison, picture, .. } => {
            let [small, whole] = shown.different[*picture];
            let (count, reference) = (comparison.pixels_that_differ(), shown.reference.unwrap_or(whole));
            let (title, thumbnail) = (details(&column.picture, comparison), thumbnail(Some(small)));
            format!(
                "<td class=\"{class}\" data-a=\"{whole}\" data-b=\"{reference}\" title=\"{title}\"><button>\
                 {thumbnail}<b>{mark} {count} px</b>{reason}</button></td>\n"
            )
        }
        _ => format!("<td class=\"{class}\"><b>{mark}</b>{reason}</td>\n"),
    }
}

/// The measures of a difference, escaped.
fn details(picture: &str, comparison: &Comparison) -> String {
    let largest = comparison.largest.map_or(String::new(), |largest| largest.to_string());
    let text = format!(
        "{picture}: {} of {} pixels differ, {} by more than one level. Largest difference {largest}. Root mean \
         square error {:.3} levels.",
        comparison.pixels_that_differ(),
        comparison.pixels(),
        comparison.pixels_differing_by_more_than(1),
        comparison.root_mean_square_error
    );
    html(&text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tools::grade::Submission;

    #[test]
    fn a_picture_is_embedded_once_and_an_equal_one_not_at_all() {
        let picture = |level: u8| Picture::from_rgb(1, 1, vec![level; 3]);
        let submissions =
            vec![0, 9, 9].into_iter().map(|level| Submission::Picture(picture(level))).collect();
        let tolerance = Default::default();
        let (column, wrong) =
            Column::graded("<p>".into(), &picture(0), submissions, tolerance, |_| Vec::new());
        let mut page = Page::default();
        page.add(&picture(0), &wrong);
        page.add_ungraded();
        let missing = Column::ungraded("q".into(), "none".into(), 3);
        let names = ["<b>", "\"", "c"].map(str::to_owned).to_vec();
        let table = Table { tolerance, names, columns: vec![column, missing], notes: vec!["<i>".into()] };
        let html = page.finish(&table);
        assert_eq!(html.matches(&file(&picture(9))).count(), 2, "a thumbnail and the picture");
        assert_eq!(html.matches("data-a=").count(), 2);
        for text in
            ["&lt;b&gt;", "&lt;p&gt;", "<li>&lt;i&gt;</li>", "no reference: none", "1 of 3 pictures pass"]
        {
            assert!(html.contains(text), "{text}");
        }
        assert!(!html.contains("<p>:") && !html.contains("http:") && !html.contains("https:"));
    }
}
