//! Whether standard output was closed when the program began, as by `>&-`.
//!
//! Rust opens the null device in its place before `main`, so that what is written there is lost without a word. It opens it
//! to read and write, a user's own `> /dev/null` only to write: by that the two can be told apart where the system lists
//! open files, which is Linux.

use std::fs;

/// Whether it was; where no one can look, it was not.
pub fn standard_output() -> bool {
    let to = fs::read_link("/proc/self/fd/1");
    let to_null = to.is_ok_and(|path| path.as_os_str() == "/dev/null");
    to_null
        && flags_of(&fs::read_to_string("/proc/self/fdinfo/1").unwrap_or_default())
            == Some(READ_WRITE)
}

/// How a file is open that is read and written, of the bits that say so.
const READ_WRITE: u32 = 0o2;

/// The bits of a list of an open file that say whether it is read or written.
fn flags_of(listed: &str) -> Option<u32> {
    let flags = listed.lines().find_map(|line| line.strip_prefix("flags:"))?;
    Some(u32::from_str_radix(flags.trim(), 8).ok()? & 0o3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn open_files_are_read_as_they_are_listed() {
        assert_eq!(flags_of("pos:\t0\nflags:\t0100002\nmnt_id:\t15\n"), Some(READ_WRITE));
        assert_eq!(flags_of("pos:\t0\nflags:\t0100001\n"), Some(1));
        assert_eq!(flags_of(""), None);
    }
}
