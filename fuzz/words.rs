//! Changes a text word by word, so that most of what the fuzzer tries still has the right form.

/// A small generator for the choices of one change (Marsaglia, "Xorshift RNGs", JSS 8(14), 2003).
struct Choices(u32);

impl Choices {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0 as usize % n.max(1)
    }
}

/// One to four words changed: dropped, doubled, swapped, replaced, or a stretch copied elsewhere.
pub fn changed(text: &str, seed: u32, vocabulary: &[&str], numbers: &[&str]) -> String {
    let mut choices = Choices(seed | 1);
    let mut words: Vec<String> = text.split_inclusive(char::is_whitespace).map(String::from).collect();
    for _ in 0..=choices.below(4) {
        change(&mut words, &mut choices, vocabulary, numbers);
    }
    words.concat()
}

fn change(words: &mut Vec<String>, choices: &mut Choices, vocabulary: &[&str], numbers: &[&str]) {
    let at = choices.below(words.len());
    if words.is_empty() {
        return words.push(format!("{} ", vocabulary[choices.below(vocabulary.len())]));
    }
    match choices.below(8) {
        0 => drop(words.remove(at)),
        1 => words.insert(at, words[at].clone()),
        2 => {
            let other = choices.below(words.len());
            words.swap(at, other);
        }
        3 => words[at] = format!("{} ", vocabulary[choices.below(vocabulary.len())]),
        4 => copy_stretch(words, at, choices),
        // Most changes turn one number into another, which keeps the text well formed.
        _ => change_number(words, at, choices, numbers),
    }
}

fn change_number(words: &mut [String], at: usize, choices: &mut Choices, numbers: &[&str]) {
    let is_number = |w: &String| w.trim().parse::<f64>().is_ok();
    let Some(word) = words[at..].iter_mut().find(|w| is_number(w)) else { return };
    *word = match choices.below(4) {
        0 => format!("{} ", choices.below(5)),
        1 => format!("-{} ", word.trim().trim_start_matches('-')),
        _ => format!("{} ", numbers[choices.below(numbers.len())]),
    };
}

fn copy_stretch(words: &mut Vec<String>, at: usize, choices: &mut Choices) {
    let end = (at + 1 + choices.below(16)).min(words.len());
    let stretch = words[at..end].to_vec();
    let to = choices.below(words.len());
    words.splice(to..to, stretch);
}
