//! Decides whether an output may replace an existing file.
//!
//! A pattern in the wrong place, as in `diagnose --csv *.csv`, names a recording as the output. So a file with data
//! is replaced only by a table with the same columns, as a second run of the same command writes, or with `--force`.
//! A recording may have the columns of a simulation, but an instrument records few digits, and a simulation writes all.
//! A page or drawing replaces, and is replaced, only if this program wrote the old file, which its beginning shows. Other
//! texts can be made again, and are replaced without a message.

use anyhow::{Context, Result, bail};
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// Number of bytes that are compared.
const HEAD: u64 = 1 << 16;

static FORCED: AtomicBool = AtomicBool::new(false);

/// Lets outputs replace anything from now on.
pub fn force() {
    FORCED.store(true, Ordering::Relaxed);
}

/// Whether outputs may replace anything.
pub fn is_forced() -> bool {
    FORCED.load(Ordering::Relaxed)
}

/// Refuses to replace the file at `path` by `new` if it has data that `new` does not contain.
pub fn check(path: &Path, new: &[u8]) -> Result<()> {
    // A device or pipe loses nothing, and reading it could take forever.
    if is_forced() || !path.is_file() {
        return Ok(());
    }
    let named = || path.display().to_string();
    let mut old = vec![];
    File::open(path).and_then(|file| file.take(HEAD).read_to_end(&mut old)).with_context(named)?;
    if may_replace(&old, new) {
        return Ok(());
    }
    let what = match is_drawn(&old) || is_drawn(new) {
        true => "and this program did not write it",
        false => "with other data than this run writes, such as a recording",
    };
    bail!("{} exists already, {what}; name another file, or give --force to overwrite it", named());
}

/// Refuses to replace a file that a person may have changed by hand, unless it is to be overwritten.
pub fn check_absent(path: &Path) -> Result<()> {
    if path.exists() && !is_forced() {
        bail!("{} exists already; --force overwrites it", path.display());
    }
    Ok(())
}

/// Whether bytes are a page or a drawing.
fn is_drawn(bytes: &[u8]) -> bool {
    bytes.trim_ascii_start().starts_with(b"<") || bytes.starts_with(b"\x89PNG")
}

/// Whether this program wrote the page or drawing that begins with these bytes: pages and PNG name it, and drawings have
/// its fonts.
fn is_ours(old: &[u8]) -> bool {
    let drawing = format!("font-family=\"{}\" font-size=", stiction_figure::figure::FONTS);
    let marks = ["<meta name=\"generator\" content=\"stiction\">", "Software\0stiction", &drawing];
    marks.iter().any(|mark| old.windows(mark.len()).any(|part| part == mark.as_bytes()))
}

/// Whether a file that begins with `old` may be replaced by `new`.
fn may_replace(old: &[u8], new: &[u8]) -> bool {
    if new.starts_with(old) {
        return true;
    }
    if is_drawn(old) || is_drawn(new) {
        return is_ours(old);
    }
    if old.contains(&0) {
        // Parquet, MATLAB and archives, by their first bytes.
        return new.get(..4) == old.get(..4);
    }
    let text = String::from_utf8_lossy(old);
    let mut lines: Vec<&str> = text.lines().filter(|line| !line.trim().is_empty()).collect();
    // The last line may be cut off.
    if old.len() as u64 == HEAD && lines.len() > 1 {
        lines.pop();
    }
    let rows = lines.iter().filter(|line| is_row(line)).count();
    if 2 * rows < lines.len() || rows == 0 {
        return true;
    }
    let header = new.split(|byte| *byte == b'\n').next().unwrap_or(&[]).trim_ascii_end();
    let is_signal = header.starts_with(b"t,");
    header == lines[0].trim_end().as_bytes()
        && (!is_signal
            || is_of_same_input(&lines, new)
            || 2 * lines.iter().filter(|l| is_exact(l)).count() > rows)
}

/// Whether the rows differ at most in their last cell, which is what a command adds to the rows of its input.
fn is_of_same_input(old: &[&str], new: &[u8]) -> bool {
    let rest = |line: &str| line.trim_end().rsplit_once(',').map(|(rest, _)| rest.to_owned());
    let new = String::from_utf8_lossy(&new[..new.len().min(2 * HEAD as usize)]);
    let mut new = new.lines().filter(|line| !line.trim().is_empty());
    old.iter().all(|line| new.next().is_some_and(|other| rest(other) == rest(line)))
}

/// Whether a row has a number with more digits than an instrument has.
fn is_exact(line: &str) -> bool {
    const DIGITS: usize = 12;
    let digits = |cell: &str| cell.bytes().filter(u8::is_ascii_digit).count();
    line.split(',').any(|cell| cell.contains('.') && digits(cell) > DIGITS)
}

/// Whether a line has a cell that is a number or a time.
fn is_row(line: &str) -> bool {
    line.split([',', ';', '\t', '|']).any(|cell| {
        let cell = cell.trim_matches(|c: char| c.is_whitespace() || c == '"' || c == '\'');
        let unsigned = cell.trim_start_matches(['+', '-', '.', '\u{2212}']);
        unsigned.starts_with(|c: char| c.is_ascii_digit())
    })
}

#[cfg(test)]
mod tests {
    use super::may_replace;

    #[test]
    fn data_is_replaced_by_a_table_of_the_same_columns_only() {
        let sample = "t,sp,pv,op\n0,50,49.9,50\n1,50,50.1,50\n";
        let result = "loop,verdict,S\nFIC101,sticks,4.8\n";
        for held in [
            sample,
            "0,50,49.9,50\n1,50,50.1,50\n",
            "Time;OP;PV\n01.02.2024 10:00;Bad;Bad\n",
            "time,value\n\"2024-01-01 00:00:00\",\"5\"\n",
            "FIC101.PV\t2024-01-01\t-0,5\nFIC101.OP\t2024-01-01\t5\n",
            "op\n5\n6\n7\n",
            "PAR1\0\0",
            "MATLAB 5.0 MAT-file\0",
        ] {
            assert!(!may_replace(held.as_bytes(), result.as_bytes()), "{held}");
            assert!(!may_replace(held.as_bytes(), b"<!doctype html>"), "{held}");
            assert!(may_replace(held.as_bytes(), held.as_bytes()), "{held}");
        }
        assert!(may_replace(result.as_bytes(), b"loop,verdict,S\nFIC102,unclear,\n"));
        let simulated =
            "t,sp,pv,op\n0,50,50,50\n1,50,50.10263419876123,50\n2,50,49.98263419876,50.1\n";
        assert!(may_replace(simulated.as_bytes(), b"t,sp,pv,op\r\n0,1,2,3\n"));
        assert!(!may_replace(sample.as_bytes(), simulated.as_bytes()), "a recording");
        // The last column is that of the command.
        let valve = "t,u,vp\n0,1,1\n1,2,1\n2,3,3\n";
        assert!(may_replace(valve.as_bytes(), b"t,u,vp\n0,1,1\n1,2,2\n2,3,2\n"));
        assert!(!may_replace(valve.as_bytes(), b"t,u,vp\n0,1,1\n1,2.5,2\n2,3,2\n"));
        for held in [
            "",
            "old\n",
            "# a loop\nsample_time = 1\n[process]\nnum = [1, 2]\nden = [1, 2]\nkc = 0.5\n",
            ".TH stiction 1 \"2026\"\nexit codes: 0, 1, 2\nand more\nof it\n",
        ] {
            assert!(may_replace(held.as_bytes(), result.as_bytes()), "{held}");
        }
    }

    #[test]
    fn pages_and_drawings_replace_their_own_kind_only() {
        let page = "<!DOCTYPE html><meta name=\"generator\" content=\"stiction\"><p>S</p>";
        let drawing =
            format!("<svg font-family=\"{}\" font-size=\"12\">", stiction_figure::figure::FONTS);
        for new in [page, &*drawing] {
            for ours in ["", page, &*drawing] {
                assert!(may_replace(ours.as_bytes(), new.as_bytes()), "{ours}");
            }
            assert!(may_replace(b"\x89PNG\0tEXtSoftware\0stiction", page.as_bytes()));
            for foreign in
                ["<!doctype html>\n1\n2\n", "my notes\n", "<svg><path/></svg>", "t,op\n1,2\n"]
            {
                assert!(!may_replace(foreign.as_bytes(), page.as_bytes()), "{foreign}");
            }
            assert!(!may_replace(b"\x89PNG\0IDAT", page.as_bytes()));
        }
        assert!(!may_replace(b"<!doctype html>\n1\n2\n3\n", b"loop,verdict,S\n"));
    }
}
