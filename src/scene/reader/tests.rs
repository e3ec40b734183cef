use super::*;
use crate::base::patience::Endless;

fn reader(text: &str) -> Reader<'_> {
    Reader::new(Edition::Y2004, text, &Endless)
}

#[test]
fn numbers_are_read_as_scanf_reads_them() {
    let good =
        [("1", 1.0), ("+1", 1.0), ("-.3", -0.3), ("0.", 0.0), ("1e-3", 1e-3), (".5E2", 50.0), ("-0", 0.0)];
    for (word, value) in good {
        assert_eq!(reader(word).number().unwrap(), value, "{word}");
    }
}

#[test]
fn other_words_are_not_numbers() {
    for word in
        ["", "}", ".", "+", "-", "e5", "1e", "inf", "-inf", "nan", "NaN", "+nan", "0x10", "1,5", "1f", "--1"]
    {
        assert!(reader(word).number().is_err(), "{word}");
    }
}

#[test]
fn whole_numbers() {
    for (word, value) in [("0", 0), ("+7", 7), ("007", 7), ("18446744073709551615", u64::MAX)] {
        assert_eq!(reader(word).whole().unwrap(), value, "{word}");
    }
    let error = reader("18446744073709551616").whole().unwrap_err().to_string();
    assert!(error.contains("must be below 2^64"), "{error}");
    let error = reader("x").whole().unwrap_err().to_string();
    assert!(error.contains("expected a whole"), "{error}");
}

#[test]
fn a_word_that_causes_an_error_is_not_taken() {
    let mut reader = reader("radius }");
    assert!(reader.keyword("center").is_err() && reader.number().is_err());
    assert!(reader.accept("radius"));
}

#[test]
fn a_comment_stuck_to_a_number_is_explained() {
    let error = reader("1#one").number().unwrap_err();
    assert!(error.hint.unwrap().contains("comment"));
}

#[test]
fn numbers_as_other_languages_write_them_are_explained() {
    let hint = |text| {
        let text = format!("center {text}");
        reader(&text).keyword("center").unwrap().vector().unwrap_err().hint.unwrap()
    };
    assert!(["0, 1.5, 8", "0,1.5,8", "0 1,5 8"].map(hint).iter().all(|hint| hint.contains("no commas")));
    assert_eq!([hint("1.0f 2 3"), hint("1 -2F 3")], ["write `1.0`", "write `-2`"]);
    assert!(["/* x */ 1", "0 /*x*/"].map(hint).iter().all(|hint| hint.starts_with("a comment starts")));
}

#[test]
fn a_number_after_the_last_one_of_its_field_is_explained() {
    let hint = |text, keyword| {
        let mut reader = reader(text);
        reader.keyword("center").and_then(Reader::vector).unwrap();
        reader.keyword(keyword).map(|_| ()).unwrap_err().hint
    };
    assert_eq!(
        hint("center 1 2 3 4", "radius"),
        Some("`center` takes 3 numbers, and this is one more".into())
    );
    assert_eq!(hint("center 1 2 3 radios", "radius"), Some("did you mean `radius`?".into()));
    let mut reader = reader("radius 1 2");
    reader.keyword("radius").and_then(Reader::number).unwrap();
    assert_eq!(
        reader.close("Sphere").unwrap_err().hint,
        Some("`radius` takes one number, and this is one more".into())
    );
}
