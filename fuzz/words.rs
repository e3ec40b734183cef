//! Mutations of a text word by word, so that most of the fuzzer's texts are still well formed.

/// A small random number generator for one mutation (Marsaglia, "Xorshift RNGs", JSS 8(14), 2003).
struct Choices(u32);

impl Choices {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0 as usize % n.max(1)
    }
}

/// The text with one to four changes: a word is removed, duplicated, swapped or replaced, or a range of words
/// is copied.
pub fn changed(text: &str, seed: u32, vocabulary: &[&str], numbers: &[&str]) -> String {
    let mut choices = Choices(seed | 1);
    let mut words: Vec<String> = text.split_inclusive(char::is_whitespace).map(String::from).collect();
    for _ in 0..=choices.below(4) {
        change(&mut words, &mut choices, vocabulary, numbers);
    }
    words.concat()
}

fn change(words: &mut Vec<String>, choices: &mut Choices, vocabulary: &[&str], numbers: &[&str]) {
    let index = choices.below(words.len());
    if words.is_empty() {
        return words.push(format!("{} ", vocabulary[choices.below(vocabulary.len())]));
    }
    match choices.below(8) {
        0 => drop(words.remove(index)),
        1 => words.insert(index, words[index].clone()),
        2 => {
            let other = choices.below(words.len());
            words.swap(index, other);
        }
        3 => words[index] = format!("{} ", vocabulary[choices.below(vocabulary.len())]),
        4 => copy_range(words, index, choices),
        // Most changes replace one number by another, which keeps the text well formed.
        _ => change_number(words, index, choices, numbers),
    }
}

fn change_number(words: &mut [String], index: usize, choices: &mut Choices, numbers: &[&str]) {
    let is_number = |w: &String| w.trim().parse::<f64>().is_ok();
    let Some(word) = words[index..].iter_mut().find(|w| is_number(w)) else { return };
    *word = match choices.below(4) {
        0 => format!("{} ", choices.below(5)),
        1 => format!("-{} ", word.trim().trim_start_matches('-')),
        _ => format!("{} ", numbers[choices.below(numbers.len())]),
    };
}

fn copy_range(words: &mut Vec<String>, index: usize, choices: &mut Choices) {
    let end = (index + 1 + choices.below(16)).min(words.len());
    let range = words[index..end].to_vec();
    let to = choices.below(words.len());
    words.splice(to..to, range);
}
