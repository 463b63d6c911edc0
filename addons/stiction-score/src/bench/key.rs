//! The key of a hidden half.

use sha2::{Digest, Sha256};

/// Smallest number of characters of a passphrase. Whoever has the recordings could try all shorter ones.
const LEAST: usize = 16;

/// The key of a passphrase: its SHA-256.
///
/// # Errors
/// If the passphrase has fewer than 16 characters.
pub fn key(passphrase: &str) -> Result<[u64; 4], String> {
    if passphrase.chars().count() < LEAST {
        return Err(format!(
            "the passphrase has fewer than {LEAST} characters; choose a longer passphrase"
        ));
    }
    let hash = Sha256::digest(passphrase);
    let word =
        |k: usize| hash[8 * k..8 * k + 8].iter().fold(0, |word, byte| word << 8 | u64::from(*byte));
    Ok([0, 1, 2, 3].map(word))
}

#[cfg(test)]
mod tests {
    use super::key;

    #[test]
    fn the_key_is_the_hash() {
        // SHA-256 of sixteen letters a, from `printf aaaaaaaaaaaaaaaa | sha256sum`.
        let found = key("aaaaaaaaaaaaaaaa").unwrap().map(|word| format!("{word:016x}")).concat();
        assert_eq!(found, "0c0beacef8877bbf2416eb00f2b5dc96354e26dd1df5517320459b1236860f8c");
        assert!(key("fifteen letters").unwrap_err().contains("16 characters"));
    }
}
