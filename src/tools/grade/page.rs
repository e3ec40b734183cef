//! The page of a grading: a single self-contained file. Its text is in `templates/grade.html`.

use super::reference::{Reference, Rule};
use super::{Cell, Column, Score, Table};
use crate::picture::{BadSize, Picture, Pixels};
use crate::tools::compare::{Difference, Scale};
use crate::tools::embedded::{Embedded, file, thumbnail_file};
use askama::Template;
use rayon::prelude::*;
use std::borrow::Cow;

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
    different: Vec<DifferentPicture>,
}

/// A picture that differs from the reference.
#[derive(Clone, Copy, Debug)]
struct DifferentPicture {
    thumbnail: usize,
    picture: usize,
    reference: usize,
    /// The scale on which numbers are drawn.
    scale: Option<Scale>,
}

impl Page {
    /// Adds a column that has a reference.
    pub fn add_column(&mut self, reference: &Reference) -> Result<(), BadSize> {
        let shown = drawn(&reference.pixels, reference.scale(&reference.pixels))?;
        let thumbnail = Some(self.thumbnails.add(thumbnail_file(&shown)));
        self.columns.push(Shown { thumbnail, ..Shown::default() });
        Ok(())
    }

    /// Adds more pictures that differ from the reference to the last column.
    pub fn add_different(&mut self, reference: &Reference, different: &[Pixels]) -> Result<(), BadSize> {
        let files = |picture: &Pixels| -> Result<[String; 2], BadSize> {
            let shown = drawn(picture, reference.scale(picture))?;
            Ok([thumbnail_file(&shown), file(&shown)])
        };
        let files: Vec<[String; 2]> = different.par_iter().map(files).collect::<Result<_, _>>()?;
        let Some(shown) = self.columns.last_mut() else { return Ok(()) };
        // A picture of bytes stands beside the bytes of a reference of numbers.
        let (mut own, mut last_scale) = (None, None);
        for (picture, [thumbnail, whole]) in different.iter().zip(files) {
            let scale = reference.scale(picture);
            if own.is_none() || last_scale != scale {
                own = Some(self.pictures.add(file(&*drawn(&reference.pixels, scale)?)));
                last_scale = scale;
            }
            shown.different.push(DifferentPicture {
                thumbnail: self.thumbnails.add(thumbnail),
                picture: self.pictures.add(whole),
                reference: own.unwrap_or_default(),
                scale,
            });
        }
        Ok(())
    }

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
    fn details(&self, column: &Column, difference: &Difference, shown: &DifferentPicture) -> String {
        let differ = format!(
            "{}: {} of {} pixels differ",
            column.picture,
            difference.pixels_that_differ(),
            difference.pixels()
        );
        match difference {
            Difference::Levels(levels) => {
                let largest = levels.largest.map_or(String::new(), |largest| largest.to_string());
                let more = levels.pixels_differing_by_more_than(1);
                let error = levels.root_mean_square_error;
                format!(
                    "{differ}, {more} by more than one level. Largest difference {largest}. Root mean square error \
                     {error:.3} levels."
                )
            }
            Difference::Numbers(numbers) => {
                let largest = numbers.largest.map_or("0".into(), |largest| largest.to_string());
                let in_one = numbers.pixels_not_finite_in_one();
                let scale = shown.scale.map_or(String::new(), |scale| format!(" Shown {scale}."));
                format!(
                    "{differ}. Largest difference {largest}. NaN or infinite in one of them: {in_one}.{scale}"
                )
            }
        }
    }
}

/// Returns a picture as it is shown: its bytes, or its numbers on a scale.
fn drawn(picture: &Pixels, scale: Option<Scale>) -> Result<Cow<'_, Picture>, BadSize> {
    match (picture, scale) {
        (Pixels::Numbers(numbers), Some(scale)) => scale.draw(numbers).map(Cow::Owned),
        _ => Ok(picture.bytes()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tools::grade::{ColumnGrader, NotGraded, Reason, Remark, Submission};

    #[test]
    fn a_picture_is_embedded_once_and_an_equal_one_not_at_all() {
        let picture = |level: u8| Picture::from_rgb(1, 1, vec![level; 3]);
        let reference = Reference::of_file(Pixels::Bytes(picture(0)));
        let mut page = Page::default();
        let mut grader = ColumnGrader::new(&reference, Rule::Equal, false, Some(&mut page)).unwrap();
        for level in [0, 9, 9] {
            grader.add(Submission::Picture(Pixels::Bytes(picture(level)))).unwrap();
        }
        let column = grader.finish("<p>".into(), vec![Remark::default(); 3]).unwrap();
        page.add_ungraded();
        let missing = Column::ungraded("q".into(), "none".into(), 3);
        let names = ["<b>", "\"", "c"].map(str::to_owned).to_vec();
        let not_graded =
            NotGraded { name: None, file: "<i>".into(), reason: Reason::OutsideFolders, meant_for: None };
        let columns = vec![column, missing];
        let table = Table { rule: Rule::Equal, names, columns, not_graded: vec![not_graded] };
        let html = page.finish(&table);
        assert_eq!(html.matches(&file(&picture(9))).count(), 2, "a thumbnail and the picture");
        assert_eq!(html.matches("data-a=").count(), 2);
        for text in
            ["&lt;b&gt;", "&lt;p&gt;", "<li>&lt;i&gt;: ", "no reference: none", "1 of 3 pictures pass"]
        {
            assert!(html.contains(text), "{text}");
        }
        assert!(!html.contains("<p>:") && !html.contains("http:") && !html.contains("https:"));
    }
}
