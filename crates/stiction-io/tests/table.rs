//! Tables: what is read, what is written, what is refused.

use proptest::prelude::*;
use stiction_io::{Error, Table, table};

fn parse(text: impl AsRef<[u8]>) -> Table {
    Table::parse(text.as_ref(), "test.csv").expect("a well-formed table")
}

#[test]
fn delimiters_are_recognised_outside_quotes() {
    for (text, header) in [
        ("t,u\n0,1\n1,2\n", ["t", "u"]),
        ("t;u\n0;1\n1;2\n", ["t", "u"]),
        ("t\tu\n0\t1\n1\t2\n", ["t", "u"]),
        ("\"a;b;c\",u\n0,1\n1,2\n", ["a;b;c", "u"]),
        ("\"a,b,c\";u\n0;1\n1;2\n", ["a,b,c", "u"]),
        ("\"say \"\"a;b;c\"\"\",u\n0,1\n1,2\n", ["say \"a;b;c\"", "u"]),
        ("\u{feff} t , u \n0,1\n1,2\n", ["t", "u"]),
        ("\n\nt,u\n0,1\n1,2\n", ["t", "u"]),
    ] {
        let table = parse(text);
        assert_eq!(table.header(), header, "{text:?}");
        assert_eq!(table.column("u").expect("numbers"), [1.0, 2.0], "{text:?}");
        assert_eq!(table.len(), 2);
        assert!(!table.is_empty());
    }
    assert_eq!(parse("u\n1\n2\n").column("u").expect("numbers"), [1.0, 2.0]);
}

#[test]
fn numbers_are_read_as_people_write_them() {
    let table = parse("u\n1\n-2.5\n+3\n.5\n5.\n1e-3\n1E3\n 7 \n");
    let expected = [1.0, -2.5, 3.0, 0.5, 5.0, 1e-3, 1e3, 7.0];
    assert_eq!(table.column("u").expect("numbers"), expected);
}

#[test]
fn a_cell_that_is_not_requested_may_be_anything() {
    let table = parse("note,u\nNaN,1\n,2\n");
    assert_eq!(table.column("u").expect("numbers"), [1.0, 2.0]);
    assert!(matches!(table.column("note"), Err(Error::Cell { row: 2, .. })));
}

#[test]
fn rows_are_counted_as_an_editor_counts_lines() {
    for (text, expected) in [
        ("u\n1\nx\n", 3),
        ("u\r\n1\r\nx\r\n", 3),
        ("u\n\n1\n\n\nx\n", 6),
        ("u\r\n\r\n1\r\nx", 4),
        ("\u{feff}u\r\n1\r\nx\r\n", 3),
        ("\n\nu\n1\nx\n", 5),
        ("note,u\n\"a\nb\",1\n\"c\nd\",x\n", 4),
    ] {
        match parse(text).column("u") {
            Err(Error::Cell { row, column, origin, .. }) => {
                assert_eq!((row, &*column, &*origin), (expected, "u", "test.csv"), "{text:?}");
            }
            other => panic!("{text:?}: {other:?}"),
        }
    }
}

#[test]
fn a_column_is_added_once_and_in_full() {
    let table = parse("u\n1\n2\n");
    assert_eq!(table.with_column("vp", &[0.1, -0.0]).expect("fits"), "u,vp\n1,0.1\n2,-0\n");
    let error = |name, values: &[f64]| table.with_column(name, values).unwrap_err().to_string();
    assert_eq!(error("u", &[1.0, 2.0]), "test.csv: has a column \"u\" already; rename it");
    assert_eq!(error("vp", &[1.0]), "test.csv: has 2 rows, but 1 values; give one value per row");
}

#[test]
fn columns_may_stay_empty() {
    let written = table::write(&[("t", Some(&[0.0, 0.5])), ("sp", None), ("op", Some(&[1.0]))]);
    assert_eq!(written, "t,sp,op\n0,,1\n0.5,,\n");
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// Any finite number, all sizes equally likely.
fn finite() -> impl Strategy<Value = f64> {
    any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |value| value.is_finite())
}

proptest! {
    #[test]
    fn any_bytes_are_a_table_or_an_error_that_names_the_file(
        bytes in prop::collection::vec(any::<u8>(), 0..200),
    ) {
        if let Err(error) = Table::parse(&bytes, "test.csv") {
            prop_assert!(error.to_string().starts_with("test.csv"), "{error}");
        }
    }

    /// Of the characters that matter to a CSV: what is written is read as the same table.
    #[test]
    fn a_written_table_reads_back(text in "[tu01,;\t\"\r\n\u{feff} -]{0,60}") {
        let Ok(table) = Table::parse(text.as_bytes(), "test.csv") else { return Ok(()) };
        // One row is a table, and no signal.
        prop_assume!(table.len() >= 2);
        let values: Vec<f64> = (0..table.len()).map(|k| k as f64 / 7.0).collect();
        let again = parse(table.with_column("added", &values).expect("fits"));
        let header: Vec<_> = table.header().iter().map(String::as_str).chain(["added"]).collect();
        prop_assert_eq!(again.header(), header);
        prop_assert_eq!(again.column("added").expect("numbers"), values);
        for name in table.header() {
            if let Ok(column) = table.column(name) {
                prop_assert_eq!(again.column(name).expect("the same numbers"), column);
            }
        }
    }

    #[test]
    fn numbers_read_back_the_same(values in prop::collection::vec(finite(), 2..20)) {
        let written = table::write(&[("u", Some(&values))]);
        prop_assert_eq!(bits(&parse(&written).column("u").expect("numbers")), bits(&values));
        let again = parse(parse(&written).with_column("v", &values).expect("fits"));
        prop_assert_eq!(bits(&again.column("v").expect("numbers")), bits(&values));
    }

    /// One bad cell anywhere is found where it is.
    #[test]
    fn a_bad_cell_is_pointed_at(
        rows in 2usize..20, bad in any::<prop::sample::Index>(), cell in "[a-z]{0,3}|nan|1e999",
    ) {
        let bad = bad.index(rows);
        let line = |k| if k == bad { format!("{k},{cell}\n") } else { format!("{k},1\n") };
        let text = "t,u\n".to_owned() + &(0..rows).map(line).collect::<String>();
        let error = parse(text).column("u").expect_err("a bad cell").to_string();
        let place = format!("test.csv, row {}, column \"u\": ", bad + 2);
        prop_assert!(error.starts_with(&place), "{error}");
        prop_assert!(error.contains("; "), "no remedy: {error}");
    }

    /// Times that ascend are taken; the first that does not is named.
    #[test]
    fn times_must_ascend(times in prop::collection::vec(-3i32..30, 2..12)) {
        let text = "time,u\n".to_owned()
            + &times.iter().map(|t| format!("{t},1\n")).collect::<String>();
        let fall = times.windows(2).position(|pair| pair[0] >= pair[1]);
        match (Table::parse(text.as_bytes(), "test.csv"), fall) {
            (Ok(_), None) => {}
            (Err(Error::Cell { row, .. }), Some(k)) => prop_assert_eq!(row, k + 3),
            (other, _) => prop_assert!(false, "{other:?}"),
        }
    }
}
