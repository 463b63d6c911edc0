//! Damaged binary files are refused in a sentence, and never make the readers panic.

use crate::{fixture, level5};

use level5::Writer;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;
use std::sync::atomic::{AtomicUsize, Ordering};
use stiction_io::matlab::matlab_sheets;
use stiction_io::parquet::parquet_sheets;

/// Fixtures to damage, each with other parts of the readers at work.
const FIXTURES: [&str; 11] = [
    "loop_snappy.parquet",
    "loop_zstd.parquet",
    "loop_brotli.parquet",
    "loop_v2.parquet",
    "loop_int96.parquet",
    "isdb_plain.mat",
    "isdb_zip.mat",
    "vectors.mat",
    "array.mat",
    "isdb_v73.mat",
    "references_v73.mat",
];

/// Panics in this crate, which the guard around the decoders must not hide.
static OWN_PANICS: AtomicUsize = AtomicUsize::new(0);

/// Reads `bytes` as a file of the fixture's format; what is wrong with them, if anything.
fn read(name: &str, bytes: &[u8]) -> Option<String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let report = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            // Those of the decoding crates are expected, and would flood the output.
            let is_in = |folder| panic.location().is_some_and(|l| l.file().contains(folder));
            if is_in("stiction-io/src") {
                OWN_PANICS.fetch_add(1, Ordering::Relaxed);
            }
            if is_in("stiction-io") {
                report(panic);
            }
        }));
    });
    let sheets = if name.ends_with(".mat") { matlab_sheets } else { parquet_sheets };
    match sheets(bytes, name) {
        Ok(sheets) => {
            for sheet in &sheets {
                assert!(sheet.columns.iter().all(|c| c.cells.len() == sheet.len()), "{name}");
            }
            None
        }
        Err(error) => Some(error.to_string()),
    }
}

fn read_without_panic(name: &str, bytes: &[u8], damage: &dyn std::fmt::Display) -> Option<String> {
    let result = catch_unwind(AssertUnwindSafe(|| read(name, bytes)));
    let own = OWN_PANICS.load(Ordering::Relaxed);
    match result {
        Ok(error) if own == 0 => error,
        _ => panic!("{name} makes the reader panic once {damage}"),
    }
}

#[test]
fn truncated_anywhere() {
    for name in FIXTURES {
        let bytes = fixture(name);
        for length in 0..bytes.len() {
            let damage = format!("cut to {length} bytes");
            let error = read_without_panic(name, &bytes[..length], &damage);
            // What ends between two variables is a file of its own.
            let may_be_whole = name.ends_with(".mat");
            assert!(error.is_some() || may_be_whole, "{name} is read, though {damage}");
        }
    }
}

#[test]
fn ten_thousand_flipped_bytes() {
    // Xorshift, after Marsaglia (2003).
    let mut state = 0x9e37_79b9_7f4a_7c15u64;
    let mut random = move |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below as u64) as usize
    };
    for round in 0..10_000 {
        let name = FIXTURES[round % FIXTURES.len()];
        let mut bytes = fixture(name);
        let mut damage = String::new();
        for _ in 0..=random(4) {
            // Every other time near the end, where Parquet tells where things are.
            let at = match random(2) {
                0 => random(bytes.len()),
                _ => bytes.len() - 1 - random(bytes.len().min(1500)),
            };
            let flip = 1 + random(255) as u8;
            bytes[at] ^= flip;
            damage += &format!("byte {at} is flipped by {flip:#04x}, ");
        }
        read_without_panic(name, &bytes, &damage);
    }
}

/// A Parquet file with this footer and nothing else.
fn footer(footer: &[u8]) -> Vec<u8> {
    [b"PAR1", footer, &(footer.len() as u32).to_le_bytes(), b"PAR1"].concat()
}

/// A zlib stream of many zeros.
fn zeros(count: usize) -> Vec<u8> {
    let mut stream = flate2::write::ZlibEncoder::new(vec![], flate2::Compression::best());
    for _ in 0..count / 1024 {
        stream.write_all(&[0; 1024]).expect("memory");
    }
    stream.finish().expect("memory")
}

/// Names a file, damages it, and says what its error says.
type Case = (&'static str, Vec<u8>, &'static str);

fn parquet_cases() -> Vec<Case> {
    let loop_none = fixture("loop_none.parquet");
    let encrypted = [b"PARE", &loop_none[4..]].concat();
    let half = loop_none[..loop_none.len() / 2].to_vec();
    let shortened = [&loop_none[..100], &loop_none[200..]].concat();
    let no_footer = [&loop_none[..20], &[0xff, 0xff, 0xff, 0xff], b"PAR1"].concat();
    // Version 1; a schema of 2^31 - 1 elements.
    let many_elements = [0x15, 0x02, 0x19, 0xfc, 0xff, 0xff, 0xff, 0xff, 0x07, 0x00, 0x00];
    // A schema of one element "r" with 2^31 - 1 children.
    let many_children = b"\x15\x02\x19\x1c\x48\x01r\x15\xfe\xff\xff\xff\x0f\x00\x00";
    // A schema of one element without children; no row; no row groups.
    let no_columns = b"\x15\x02\x19\x1c\x48\x01r\x15\x00\x00\x16\x00\x19\x0c\x00";
    // Version 1; an algorithm of encryption.
    let encrypted_columns = [0x15, 0x02, 0x7c, 0x00, 0x00];
    let deep = [0x1c; 3000];
    vec![
        ("empty.parquet", vec![], "is empty; a Parquet file is needed"),
        ("text.parquet", b"t,OP,PV\n0,1,2\n".to_vec(), "is not a Parquet file, which begins with"),
        ("magic.parquet", b"PAR1".to_vec(), "is cut short: a Parquet file ends with \"PAR1\""),
        ("half.parquet", half, "is cut short: a Parquet file ends with \"PAR1\""),
        ("encrypted.parquet", encrypted, "is encrypted and cannot be read; write it without"),
        ("plain.parquet", footer(&encrypted_columns), "is encrypted and cannot be read"),
        ("no_footer.parquet", no_footer, "claims a footer of 4294967295 bytes"),
        ("zeros.parquet", footer(&[0; 40]), "its footer is damaged"),
        ("deep.parquet", footer(&deep), "its footer is damaged; write the file again"),
        ("elements.parquet", footer(&many_elements), "its footer is damaged; write the file again"),
        ("children.parquet", footer(many_children), "its footer is damaged; write the file again"),
        ("columns.parquet", footer(no_columns), "has no columns; write at least one"),
        ("shortened.parquet", shortened, "column \"time\" cannot be read: "),
        (
            "nested.parquet",
            fixture("nested.parquet"),
            "column \"history.list.element\" is nested or a list; write the file without it",
        ),
        (
            "binary.parquet",
            fixture("binary.parquet"),
            "column \"blob\" cannot be read: a cell is not UTF-8 text; write the file without",
        ),
        (
            "delta.parquet",
            fixture("delta_text.parquet"),
            "column \"mode\" cannot be read: its text is stored as differences (DELTA_BYTE_ARRAY)",
        ),
    ]
}

fn matlab_cases() -> Vec<Case> {
    let w = Writer { big_endian: false };
    let file = |element: Vec<u8>| w.file(&[element]);
    let plain = fixture("isdb_plain.mat");
    let zip = fixture("isdb_zip.mat");
    let v73 = fixture("isdb_v73.mat");
    let doubles = |count: usize| w.element(9, &vec![0; 8 * count]);
    let mut nested = w.doubles("", &[1.0, 2.0]);
    for _ in 0..60 {
        nested = w.cell("deep", &[nested]);
    }
    let mut bomb = [w.word(15), w.word(0)].concat();
    bomb.extend(zeros(110 << 20));
    let size = bomb.len() as u32 - 8;
    bomb[4..8].copy_from_slice(&w.word(size));
    let nameless = [w.small(5, &w.word(0)), w.element(1, b"PV")];
    let words = w.element(4, &[0; 8]);
    vec![
        ("empty.mat", vec![], "is empty; a MATLAB file is needed"),
        (
            "no_columns.mat",
            file(w.array(6, &[5, 0], "PV", &[w.element(9, &[])])),
            "has no vectors of two or more numbers",
        ),
        ("text.mat", b"t,OP,PV\n0,1,2\n".to_vec(), "is not a MATLAB file; save it in MATLAB"),
        ("header.mat", plain[..100].to_vec(), "is cut short within its header"),
        (
            "version4.mat",
            fixture("version4.mat")[..90].to_vec(),
            "version 4 and is cut short in the matrix at byte 0",
        ),
        ("none.mat", w.file(&[]), "has no variables; save some with save(..., '-v7')"),
        ("half.mat", plain[..plain.len() / 2].to_vec(), "is cut short: "),
        ("half_zip.mat", zip[..zip.len() / 2].to_vec(), "is cut short: "),
        ("kind.mat", file(w.word(0x0009_0001)), "an element is of an unknown kind"),
        ("class.mat", file(w.element(14, &w.word(0))), "is cut short; copy or save it again"),
        (
            "zlib.mat",
            file(w.element(15, b"not zlib")),
            "a variable cannot be decompressed: corrupt deflate stream; save it again (at byte 128",
        ),
        ("bomb.mat", file(bomb), "would take more than 9"),
        (
            "numbers.mat",
            file(w.array(6, &[2, 3], "PV", &[doubles(4)])),
            "is damaged: \"PV\" has 4 of its 6 numbers; save it again",
        ),
        (
            "not_numbers.mat",
            file(w.array(6, &[2, 3], "PV", &[w.element(16, b"text")])),
            "is damaged: an array has no numbers",
        ),
        (
            "letters.mat",
            file(w.array(4, &[1, 1], "s", &[doubles(1)])),
            "a text is stored as numbers",
        ),
        (
            "dimensions.mat",
            file(w.array(6, &[u32::MAX >> 1; 9], "PV", &[doubles(1)])),
            "is damaged: an array has impossible dimensions",
        ),
        (
            "cells.mat",
            file(w.array(1, &[u32::MAX >> 1, 1], "c", &[doubles(1)])),
            "is damaged: 2147483647 cells or structs do not fit into its bytes; save it again, in \
             \"c\"",
        ),
        // As many rows of text as there are numbers, each without a character.
        ("rows.mat", file(w.array(4, &[u32::MAX >> 1, 0], "s", &[])), "variables are \"s\""),
        (
            "no_array.mat",
            file(w.array(1, &[1, 1], "c", &[words])),
            "a cell or field is not an array",
        ),
        (
            "nameless.mat",
            file(w.array(2, &[1, 1], "s", &nameless)),
            "is damaged: a struct has fields without names; save it again, in \"s\"",
        ),
        ("nested.mat", file(nested), "has structs or cells nested deeper than 48; flatten it"),
        (
            "scalars.mat",
            w.file(&[w.doubles("Ts", &[1.0]), w.text("title", "x")]),
            "has no vectors of two or more numbers, alone or in a struct; its variables are \
             \"Ts\", \"title\"",
        ),
        (
            "timetable.mat",
            file(w.object("TT", "timetable")),
            "TT is a timetable, which only MATLAB reads (use writetable or writetimetable",
        ),
        ("half_73.mat", v73[..v73.len() / 2].to_vec(), "save it with save(..., '-v7')"),
        ("signature.mat", v73[..520].to_vec(), "is of MATLAB's version 7.3 and cannot be read ("),
    ]
}

#[test]
fn malformed_files_are_refused_in_a_sentence() {
    for (name, bytes, expected) in parquet_cases().into_iter().chain(matlab_cases()) {
        let error = read_without_panic(name, &bytes, &"malformed").unwrap_or_default();
        assert!(error.starts_with(&format!("{name}: ")), "{name}: {error}");
        assert!(error.contains(expected), "{error}\nshould say: {expected}");
        assert!(error.len() < 400, "{error}");
    }
}
