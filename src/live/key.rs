//! The secret in the page's address.

use subtle::ConstantTimeEq;

/// The number of random bits.
const BITS: usize = 128;

/// A random number that only the address shows, in hexadecimal digits.
pub struct Key(String);

impl Key {
    /// A new key from the system's random numbers.
    pub fn new() -> Result<Self, getrandom::Error> {
        random_digits().map(Self)
    }

    /// Its digits.
    pub fn digits(&self) -> &str {
        &self.0
    }

    /// Whether `given` is the key. The time that this takes does not tell how much of it is right.
    pub fn is(&self, given: &str) -> bool {
        self.0.as_bytes().ct_eq(given.as_bytes()).into()
    }
}

/// Random hexadecimal digits that nobody can guess.
pub fn random_digits() -> Result<String, getrandom::Error> {
    let mut bytes = [0; BITS / 8];
    getrandom::fill(&mut bytes)?;
    Ok(bytes.map(|byte| format!("{byte:02x}")).concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_itself_and_nothing_else() {
        let (key, other) = (Key::new().unwrap(), Key::new().unwrap());
        let digits = key.digits().to_owned();
        assert_eq!(digits.len(), BITS / 4);
        assert!(key.is(&digits) && !key.is(other.digits()));
        assert!(!key.is("") && !key.is(&digits[1..]) && !key.is(&(digits + "0")));
    }
}
