//! Compares the words of a scene with the keywords of the grammar.

/// Whether `word` is `keyword`. The name of a field may also be spelt with underscores, as on the grammar
/// page of 2003 (`num_objects` for `numObjects`).
pub fn is_keyword(word: &str, keyword: &str) -> bool {
    word == keyword
        || (keyword.starts_with(|first: char| first.is_ascii_lowercase()) && is_snake_case(word, keyword))
}

fn is_snake_case(word: &str, keyword: &str) -> bool {
    let expected = keyword.chars().flat_map(|character| {
        let separator = character.is_ascii_uppercase().then_some('_');
        separator.into_iter().chain([character.to_ascii_lowercase()])
    });
    word.chars().eq(expected)
}

/// The keyword that the author of `word` most likely meant: the one with the smallest edit distance, if at
/// most a third of the characters differ.
pub fn nearest<'k>(word: &str, keywords: &[&'k str]) -> Option<&'k str> {
    // No keyword is longer than this, and the limit bounds the time that hostile input can take.
    const MAX_LENGTH: usize = 40;
    if !word.starts_with(char::is_alphabetic) || word.len() > MAX_LENGTH {
        return None;
    }
    let plain = simplified(word);
    let max_distance = ((plain.chars().count() + 1) / 3).max(1);
    keywords
        .iter()
        .map(|&keyword| (strsim::levenshtein(&plain, &simplified(keyword)), keyword))
        .filter(|&(distance, _)| distance <= max_distance)
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, keyword)| keyword)
}

/// The word without what is most easily confused: case and underscores.
fn simplified(word: &str) -> String {
    word.chars().filter(|&character| character != '_').flat_map(char::to_lowercase).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_may_be_spelt_with_underscores() {
        assert!(is_keyword("numObjects", "numObjects"));
        assert!(is_keyword("num_objects", "numObjects"));
        assert!(is_keyword("index_of_refraction", "indexOfRefraction"));
        assert!(is_keyword("obj_file", "obj_file"));
        assert!(!is_keyword("num_Objects", "numObjects"));
        assert!(!is_keyword("numobjects", "numObjects"));
        assert!(!is_keyword("material_index", "MaterialIndex"));
    }

    #[test]
    fn the_nearest_keyword_is_found() {
        let keywords = ["Sphere", "Plane", "Triangle", "TriangleMesh"];
        assert_eq!(nearest("Sphre", &keywords), Some("Sphere"));
        assert_eq!(nearest("plane", &keywords), Some("Plane"));
        assert_eq!(nearest("Triangel", &keywords), Some("Triangle"));
        assert_eq!(nearest("triangle_mesh", &keywords), Some("TriangleMesh"));
        for far in ["Teapot", "}", "12", "", &"S".repeat(1_000_000)] {
            assert_eq!(nearest(far, &keywords), None);
        }
    }

    #[test]
    fn a_word_too_long_or_without_a_letter_has_no_nearest_keyword() {
        let long = "a".repeat(40);
        assert_eq!(nearest(&long, &[&long]), Some(long.as_str()));
        let longer = "a".repeat(41);
        assert_eq!((nearest(&longer, &[&longer]), nearest("1", &["1"])), (None, None));
    }

    #[test]
    fn a_third_of_a_word_may_be_wrong() {
        assert_eq!((nearest("xy", &["xz"]), nearest("xy", &["wz"])), (Some("xz"), None));
        assert_eq!(nearest("abcde", &["abcxy"]), Some("abcxy"));
        assert_eq!(nearest("abcdef", &["abcxyz"]), None);
    }
}
