//! The page of a grading: a single self-contained file. Its text is in `templates/grade.html`.

use super::{Cell, Column, Score, Table};
use crate::picture::Picture;
use crate::tools::compare::{Comparison, Tolerance};
use crate::tools::embedded::{Embedded, file, thumbnail_file};
use askama::Template;
use rayon::prelude::*;

/// A page under construction. Columns are added one after the other.
#[derive(Debug, Default)]
pub struct Page {
    thumbnails: Embedded,
    /// The pictures shown after a click.
    pictures: Embedded,
    columns: Vec<Shown>,
}

/// The indices of a column's pictures.
#[derive(Debug, Default)]
struct Shown {
    /// The thumbnail of the reference.
    thumbnail: Option<usize>,
    /// The reference, if any picture differs from it.
    reference: Option<usize>,
    /// The indices of each different picture's thumbnail and of the picture.
    different: Vec<[usize; 2]>,
}

impl Page {
    /// Adds a column that has a reference.
    pub fn add_column(&mut self, reference: &Picture) {
        let thumbnail = Some(self.thumbnails.add(thumbnail_file(reference)));
        self.columns.push(Shown { thumbnail, ..Shown::default() });
    }

    /// Adds more pictures that differ from the reference to the last column.
    pub fn add_different(&mut self, reference: &Picture, different: &[Picture]) {
        let files: Vec<[String; 2]> =
            different.par_iter().map(|picture| [thumbnail_file(picture), file(picture)]).collect();
        let Some(shown) = self.columns.last_mut() else { return };
        shown.reference = Some(self.pictures.add(file(reference)));
        for [small, whole] in files {
            shown.different.push([self.thumbnails.add(small), self.pictures.add(whole)]);
        }
    }

    /// Adds a column without a reference.
    pub fn add_ungraded(&mut self) {
        self.columns.push(Shown::default());
    }

    /// Returns the page of a table with the added columns.
    pub fn finish(&self, table: &Table) -> String {
        let (thumbnails, pictures) = (self.thumbnails.files(), self.pictures.files());
        Filled { table, columns: &self.columns, thumbnails, pictures }.to_string()
    }
}

#[derive(Template)]
#[template(path = "grade.html")]
struct Filled<'p> {
    table: &'p Table,
    columns: &'p [Shown],
    thumbnails: Vec<&'p str>,
    pictures: Vec<&'p str>,
}

impl<'p> Filled<'p> {
    fn columns(&self) -> impl Iterator<Item = (&'p Column, &'p Shown)> {
        self.table.columns.iter().zip(self.columns)
    }

    /// Describes the measures of a difference.
    fn details(&self, column: &Column, comparison: &Comparison) -> String {
        let largest = comparison.largest.map_or(String::new(), |largest| largest.to_string());
        format!(
            "{}: {} of {} pixels differ, {} by more than one level. Largest difference {largest}. Root mean square \
             error {:.3} levels.",
            column.picture,
            comparison.pixels_that_differ(),
            comparison.pixels(),
            comparison.pixels_differing_by_more_than(1),
            comparison.root_mean_square_error
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tools::grade::Submission;

    #[test]
    fn a_picture_is_embedded_once_and_an_equal_one_not_at_all() {
        let picture = |level: u8| Picture::from_rgb(1, 1, vec![level; 3]);
        let submissions = [0, 9, 9].map(|level| Ok::<_, ()>(Submission::Picture(picture(level))));
        let tolerance = Default::default();
        let mut page = Page::default();
        page.add_column(&picture(0));
        let show = |wrong: &[Picture], _: &[bool]| {
            page.add_different(&picture(0), wrong);
            Vec::new()
        };
        let column = Column::graded("<p>".into(), &picture(0), submissions, tolerance, show).unwrap();
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
