//! The code of a result: ten characters for lesson, class, tries and marks, with a checksum over these and the name.
//!
//! The alphabet is Crockford's base 32, which has no I, L, O and U. Half of the 50 bits are the checksum, so a typo in the
//! code or the name is refused. The code is no proof: who knows this file can make one.

use crate::course::{CLASSES, LESSONS};
use sha2::{Digest, Sha256};

const ALPHABET: &[u8; 32] = b"0123456789ABCDEFGHJKMNPQRSTVWXYZ";
/// Bits of the content, and of the checksum.
const HALF: u32 = 25;
/// Largest number of tries that a code can show. More tries are shown as this number.
pub(super) const TRIES: u32 = 7;

/// What a code says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Result {
    /// The number of the lesson, from 1.
    pub lesson: u32,
    /// The number of the class.
    pub class: u32,
    /// How often the answers were checked.
    pub tries: u32,
    /// One bit per question: right, or not.
    pub marks: u32,
}

/// A name without differences that carry no meaning.
fn plain(name: &str) -> String {
    name.split_whitespace().collect::<Vec<_>>().join(" ").to_lowercase()
}

fn checksum(name: &str, content: u32) -> u32 {
    let hash = Sha256::digest(format!("{}\n{content}", plain(name)));
    hash.iter().take(4).fold(0, |sum, byte| sum << 8 | u32::from(*byte)) >> (32 - HALF)
}

impl Result {
    /// Code for the student of this name.
    pub fn code(self, name: &str) -> String {
        let Self { lesson, class, tries, marks } = self;
        let content = ((lesson << 14 | class) << 3 | tries.min(TRIES)) << 5 | marks;
        let letters = |half: u32| {
            let letter = |k: u32| char::from(ALPHABET[(half >> (5 * k)) as usize % 32]);
            (0..5).rev().map(letter).collect::<String>()
        };
        format!("{}-{}", letters(content), letters(checksum(name, content)))
    }

    /// The result in a code of this name, or why it has none.
    pub fn read(name: &str, code: &str) -> std::result::Result<Self, String> {
        if plain(name).is_empty() {
            return Err("the name is missing; write name and code in one line".to_owned());
        }
        let mut bits = 0u64;
        let mut letters = 0;
        for letter in code.chars().filter(|letter| *letter != '-') {
            let letter = match letter.to_ascii_uppercase() {
                'O' => '0',
                'I' | 'L' => '1',
                other => other,
            };
            let value = ALPHABET.iter().position(|known| char::from(*known) == letter);
            let value = value.ok_or_else(|| {
                format!("a code has no \"{letter}\"; copy the code from the lab again")
            })?;
            letters += 1;
            bits = bits << 5 | value as u64;
            if letters > 10 {
                break;
            }
        }
        if letters != 10 {
            return Err("a code has ten letters and digits; copy it from the lab again".to_owned());
        }
        let (content, sum) = ((bits >> HALF) as u32, bits as u32 & ((1 << HALF) - 1));
        let read = Self {
            lesson: content >> 22,
            class: content >> 8 & 0x3fff,
            tries: content >> 5 & TRIES,
            marks: content & 31,
        };
        let known =
            (1..=LESSONS.len() as u32).contains(&read.lesson) && CLASSES.contains(&read.class);
        if sum != checksum(name, content) || !known {
            return Err(
                "code and name do not match; compare both with the student's page".to_owned()
            );
        }
        Ok(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DONE: Result = Result { lesson: 4, class: 9999, tries: 2, marks: 0b1011 };

    #[test]
    fn a_code_is_read_back_in_any_case_and_with_letters_that_look_alike() {
        let mut seen = std::collections::BTreeSet::new();
        for lesson in 1..=6 {
            for (class, tries, marks) in [(1, 1, 0), (1, 1, 31), (1234, 7, 5), (9999, 3, 1)] {
                let done = Result { lesson, class, tries, marks };
                let code = done.code("Åsa  Öberg");
                assert!(code.len() == 11 && seen.insert(code.clone()), "{code}");
                assert_eq!(Result::read("åsa öberg ", &code), Ok(done));
                let sloppy = code.replace('0', "o").replace('1', "l").replace('-', "");
                assert_eq!(Result::read("Åsa Öberg", &sloppy.to_lowercase()), Ok(done));
            }
        }
        // More tries than a code can show are shown as the most.
        let many = Result { tries: 100, ..DONE };
        assert_eq!(Result::read("A", &many.code("A")), Ok(Result { tries: TRIES, ..DONE }));
    }

    #[test]
    fn every_typo_of_one_letter_and_every_swap_of_neighbours_is_refused() {
        let code = DONE.code("Ada Lovelace");
        assert_eq!(Result::read("Ada Lovelace", &code), Ok(DONE));
        let letters: Vec<char> = code.chars().collect();
        for (k, was) in letters.iter().enumerate().filter(|(_, was)| **was != '-') {
            for other in ALPHABET.iter().map(|each| char::from(*each)).filter(|each| each != was) {
                let mut typo = letters.clone();
                typo[k] = other;
                let typo: String = typo.into_iter().collect();
                assert!(Result::read("Ada Lovelace", &typo).is_err(), "{typo}");
            }
            let mut swapped = letters.clone();
            swapped.swap(k, (k + 1) % letters.len());
            let swapped: String = swapped.into_iter().collect();
            if swapped.replace('-', "") != code.replace('-', "") {
                assert!(Result::read("Ada Lovelace", &swapped).is_err(), "{swapped}");
            }
        }
        for (name, code, word) in [
            ("Ada Lovelac", &*code, "do not match"),
            ("", &*code, "name is missing"),
            ("Ada Lovelace", &code[1..], "ten letters"),
            ("Ada Lovelace", "", "ten letters"),
            ("Ada Lovelace", &"A".repeat(1000), "ten letters"),
            ("Ada Lovelace", "ABCDE-FGHU7", "no \"U\""),
            ("Ada Lovelace", "ABCDE-FGHÄ7", "no \"Ä\""),
        ] {
            let why = Result::read(name, code).unwrap_err();
            assert!(why.contains(word), "{name} {code}: {why}");
        }
    }
}
