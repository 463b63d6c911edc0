//! Odd and malformed files, each with what is read from it or what the message must say.

use proptest::prelude::*;
use stiction_io::ReadOptions;
use stiction_io::reading;
use stiction_recording::recording::{Channel, LoopType, Mode, Quality, Recording};

/// A file of the folder `corpus`, a mapping file for it, what is read from it, if anything, and what the
/// notes or the message must contain.
pub struct Case {
    pub file: &'static str,
    pub bytes: &'static [u8],
    pub mapping: &'static str,
    pub read: Result<&'static str, ()>,
    pub said: &'static [&'static str],
}

macro_rules! case {
    ($file:literal, $mapping:literal, $read:expr, $said:expr) => {
        Case {
            file: $file,
            bytes: include_bytes!(concat!("corpus/", $file)),
            mapping: $mapping,
            read: $read,
            said: $said,
        }
    };
}

/// The expected readings have the form
/// `NAME(TYPE) @START op TIME:VALUE ... (LOW..HIGH) pv ... mode TIME:MODE ... | NEXT LOOP`, where `b` is a
/// bad value, `m` a missing and `?` an uncertain one.
pub const CASES: &[Case] = &[
    case!("plain.csv", "", Ok("f op 0:50 1:51 pv 0:1.5 1:1.6"), &[]),
    case!("semicolon-comma.csv", "", Ok("f op 0:50 1:51 pv 0:1.5 1:1.6"), &[]),
    case!("tab.tsv", "", Ok("f op 0:50 1:51 pv 0:1.5 1:1.6"), &[]),
    case!("bar.csv", "", Ok("f op 0:50 1:51 pv 0:1.5 1:1.6"), &[]),
    case!("quoted-comma.csv", "", Ok("f op 0:50 1:51 pv 0:1.5 1:1.6"), &[]),
    case!("crlf.csv", "", Ok("f op 0:50 1:51"), &[]),
    case!("bare-cr.csv", "", Ok("f op 0:50 1:51"), &[]),
    case!("mixed-ends.csv", "", Ok("f op 0:50 1:51"), &[]),
    case!("no-last-end.csv", "", Ok("f op 0:50 1:51"), &[]),
    case!("utf8-mark.csv", "", Ok("f op 0:50 1:51"), &[]),
    case!("utf16le.csv", "", Ok("f op 0:50 1:51"), &[]),
    case!("utf16be.csv", "", Ok("f op 0:50 1:51"), &[]),
    case!("utf16-unmarked.csv", "", Ok("f op 0:50 1:51 pv 0:2 1:3"), &[]),
    case!("latin1.csv", "", Ok("f op 0:50 1:51"), &["line 1 is not UTF-8"]),
    case!("sep-line.csv", "", Ok("f op 0:50 1:51"), &[]),
    case!("blank-lines.csv", "", Ok("f op 0:50 1:51"), &[]),
    case!("trailing-delimiters.csv", "", Ok("f op 0:50 1:51"), &[]),
    case!("trailing-in-rows.csv", "", Ok("f op 0:50 1:51"), &[]),
    case!("spaces.csv", "", Ok("f op 0:50 1:51"), &[]),
    case!("comments.csv", "", Ok("f op 0:50 1:51"), &["1 comment lines among the rows"]),
    case!(
        "header-in-comment.csv",
        "",
        Ok("f op 0:50 1:51"),
        &["the comment in row 1 is used as the header"]
    ),
    case!("metadata.csv", "", Ok("FIC7(flow) op 0:50 1:51 pv 0:1 1:2"), &[]),
    case!("units-row.csv", "", Ok("f op 0:50 1:51 (0..100) pv 0:1 1:2"), &[]),
    case!("units-in-brackets.csv", "", Ok("f op 0:12 1:13 (4..20) pv 0:1 1:2"), &[]),
    case!("index-column.csv", "", Ok("f op 0:50 1:51"), &[]),
    case!("sample-time-above.csv", "", Ok("f op 0:50 5:51 pv 0:1 5:2"), &[]),
    case!("upper-case.csv", "", Ok("f op 0:50 1:51 pv 0:1 1:1 sp 0:2 1:2 vp 0:49 1:49"), &[]),
    case!("historian-words.csv", "", Ok("f op 0:50 1:b 2:b 3:m 4:b 5:m 6:m 7:m 8:b 9:51"), &[]),
    case!("own-word.csv", "bad_text = [\"kaputt\"]", Ok("f op 0:50 1:b"), &[]),
    case!("quality-words.csv", "", Ok("f op 0:50 1:b 2:52?"), &[]),
    case!(
        "quality-opc-da.csv",
        "",
        Ok("f op 0:50 1:b 2:52? 3:53"),
        &["interpreted as OPC DA codes"]
    ),
    case!("quality-opc-ua.csv", "", Ok("f op 0:50 1:b"), &["OPC UA status codes"]),
    case!("quality-excuses-text.csv", "", Ok("f op 0:50 1:b"), &[]),
    case!(
        "unknown-word.csv",
        "",
        Err(()),
        &[
            "f.csv, row 3, column \"op\": \"Kaputt\" is neither a number nor a known word",
            "bad_text Kaputt"
        ]
    ),
    case!(
        "quality-unknown.csv",
        "",
        Err(()),
        &[
            "row 2, column \"quality\": \"purple\" is not a known quality",
            "quality purple=good or bad"
        ]
    ),
    case!(
        "quality-undecided.csv",
        "",
        Err(()),
        &["row 2, column \"quality\": 0 is an ambiguous quality code", "quality 0=good or bad"]
    ),
    case!(
        "quality-decided.csv",
        "[quality]\n\"0\" = \"good\"\n\"1\" = \"bad\"",
        Ok("f op 0:50 1:b"),
        &[]
    ),
    case!("infinite.csv", "", Err(()), &["row 3, column \"op\": \"inf\""]),
    case!(
        "too-large.csv",
        "",
        Err(()),
        &["row 3, column \"op\": \"1e999\" is not a finite number"]
    ),
    case!("thousands.csv", "", Ok("f op 0:50 pv 0:1234.5"), &[]),
    case!(
        "mixed-marks.csv",
        "",
        Err(()),
        &[
            "row 3, column \"op\": \"51,5\" has a decimal \",\", but the other numbers of the file have \".\""
        ]
    ),
    case!(
        "unit-in-cell.csv",
        "",
        Err(()),
        &["row 2, column \"op\": \"50 t/h\" is not a finite number", "without units"]
    ),
    case!(
        "empty.csv",
        "",
        Err(()),
        &["f.csv: is empty; a header row and rows of samples are needed"]
    ),
    case!("only-blank.csv", "", Err(()), &["is empty"]),
    case!("header-only.csv", "", Err(()), &["has no row of samples below its header"]),
    case!(
        "headerless.csv",
        "",
        Err(()),
        &["row 1 must name the columns, but reads \"0,50\"; add a header such as \"time,pv,op\""]
    ),
    case!(
        "headerless-long.csv",
        "",
        Ok("FIC1(flow) @1704067200 op 0:50 1:51"),
        &[
            "the file has no header; by what they hold, its columns are \"tag\", \"time\", \"value\""
        ]
    ),
    case!("short-row.csv", "", Err(()), &["row 3 has 2 cells, but the header has 3 columns"]),
    case!("long-row.csv", "", Err(()), &["row 3 has 3 cells, but the header has 2 columns"]),
    case!(
        "same-names.csv",
        "",
        Err(()),
        &["\"op (column 2)\" and \"op (column 3)\" can both be the OP", "map op=op (column 2)"]
    ),
    case!("same-names.csv", "columns = { \"op (column 3)\" = \"op\" }", Ok("f op 0:1"), &[]),
    case!("zero-bytes.csv", "", Err(()), &["line 3 holds a zero byte"]),
    case!("comment-only.csv", "", Err(()), &["names no columns"]),
    case!("json.json", "", Err(()), &["f.csv: "]),
    case!("zip.xlsx", "", Err(()), &["cannot be read as a workbook", "save it as .xlsx again"]),
    case!("gzip.csv.gz", "", Err(()), &["cannot be unpacked with gzip"]),
    case!(
        "influx-annotated.csv",
        "",
        Ok(
            "FIC101(flow) @1677916800 op 0:44.97 1:45.02 2:44.98 pv 0:60.06 1:59.96 2:60.03 sp 0:60 1:60 2:60"
        ),
        &["CSV of InfluxDB, of 3 tables; its signals are named by \"_measurement\", \"_field\""]
    ),
    case!(
        "influx-tags.csv",
        "",
        Ok(
            "FIC101(flow) @1677916800 op 0:45 1:46 pv 0:60 1:b | LIC2(level) @1677916800 op 0:50 1:51 pv 0:1 1:2"
        ),
        &["of 4 tables; its signals are named by \"id\""]
    ),
    case!(
        "influx-pivoted.csv",
        "",
        Ok(
            "FIC101(flow) @1677916800 op 0:45 1:46 pv 0:60 1:61 | FIC102(flow) @1677916800 op 0:50 1:51 pv 0:1 1:2"
        ),
        &["of 2 tables; its signals are named by \"loop\""]
    ),
    case!(
        "influx-headers.csv",
        "",
        Ok("f @1677916800 op 0:45 1:46 2:47 pv 0:60 1:61 2:62 sp 0:60 1:60 2:60"),
        &["of 2 tables"]
    ),
    case!(
        "influx-error.csv",
        "",
        Err(()),
        &[
            "row 9 is an error of the query, not a sample: \"runtime error: out of memory\"",
            "export it again"
        ]
    ),
    case!("broken-utf16.csv", "", Err(()), &["begins like UTF-16LE text"]),
    case!("bad-sample-time.csv", "", Err(()), &["has \"sample_time: soon\" above the table"]),
    case!(
        "no-op.csv",
        "",
        Err(()),
        &[
            "has no column known as the controller output (OP); its columns are \"t\", \"pv\", \"sp\"",
            "map op=COLUMN"
        ]
    ),
    case!(
        "no-time.csv",
        "",
        Err(()),
        &["has no column of times", "map time=COLUMN", "sample_time 1"]
    ),
    case!("no-time-but-told.csv", "sample_time = 0.5", Ok("f op 0:50 0.5:51 pv 0:1 0.5:2"), &[]),
    case!("two-ops.csv", "", Err(()), &["\"op\" and \"output\" can both be the OP", "map op=op"]),
    case!(
        "two-times.csv",
        "",
        Ok("f op 0:50"),
        &["\"t\" is used as the time, \"timestamp\" not", "map time=timestamp"]
    ),
    case!(
        "mv-alone.csv",
        "",
        Ok("f op 0:50 1:51 pv 0:1 1:2"),
        &["\"mv\" is interpreted as the manipulated variable, the OP", "map vp=mv"]
    ),
    case!(
        "mv-beside-op.csv",
        "",
        Ok("f op 0:50 1:51 vp 0:49 1:49"),
        &["\"mv\" is beside an OP and is interpreted as the measured valve position"]
    ),
    case!(
        "given-for-a-loop.csv",
        "[loop.FIC1]\npv = \"10FT1.DACA\"\nop = \"10FC1\"",
        Ok("FIC1(flow) op 0:50 1:51 pv 0:1 1:2"),
        &[]
    ),
    case!(
        "given-but-missing.csv",
        "[loop.FIC1]\npv = \"10FT1\"",
        Ok("f op 0:50"),
        &["the file lacks these loops of the mapping: \"FIC1\""]
    ),
    case!(
        "wide.csv",
        "",
        Ok("FIC1(flow) op 0:50 1:51 pv 0:1 1:2 | LIC2(level) op 0:20 1:21 sp 0:5 1:5"),
        &[]
    ),
    case!(
        "wide-mixed-case.csv",
        "",
        Ok("fic1(flow) op 0:50 1:51 pv 0:1 1:2"),
        &["loop TI5 has no OP and is not read"]
    ),
    case!(
        "wide-paths.csv",
        "",
        Ok("A/PIC1/PID1(pressure) op 0:50 1:51 pv 0:1 1:2 mode 0:A 1:M"),
        &[]
    ),
    case!("wide-quality.csv", "", Ok("TIC1(temperature) op 0:50 1:51 pv 0:1 1:b"), &[]),
    case!("one-named-loop.csv", "", Ok("FIC1(flow) op 0:50 1:51 mode 0:C 1:A"), &[]),
    case!(
        "pattern.csv",
        "pattern = \"{signal}>{loop}\"",
        Ok("FIC1(flow) op 0:50 1:51 pv 0:1 1:2"),
        &[]
    ),
    case!(
        "own-signals.csv",
        "[signals]\npv = [\"MW\"]\nop = [\"Y\"]",
        Ok("FIC1(flow) op 0:50 1:51 pv 0:1 1:2"),
        &[]
    ),
    case!("long.csv", "", Ok("FIC1(flow) op 0.5:50 2:b pv 0:1 3:2 mode 0:A"), &[]),
    case!(
        "long-historian.csv",
        "",
        Ok("FIC1(flow) @1704067200 op 0:50.5 60:b 120:52.5"),
        &["percent of confidence"]
    ),
    case!(
        "long-unknown-word.csv",
        "",
        Err(()),
        &["row 3, column \"value\" of \"FIC1.OP\": \"Kaputt\""]
    ),
    case!(
        "long-no-tag.csv",
        "",
        Err(()),
        &["row 3, column \"tag\": is empty; every row needs a tag"]
    ),
    case!(
        "long-no-op.csv",
        "",
        Err(()),
        &["has no column known as the controller output", "\"FIC1.PV\""]
    ),
    case!(
        "long-two-values.csv",
        "",
        Err(()),
        &["\"value\" and \"val\" can both be the value", "map value=value"]
    ),
    case!(
        "time-not-a-number.csv",
        "",
        Err(()),
        &["row 3, column \"t\": \"later\" is not a number, as this time format requires"]
    ),
    case!(
        "mode-codes.csv",
        "",
        Ok("f op 0:50 1:51 2:52 mode 0:M 1:A 2:C"),
        &["mode codes are interpreted as 0 manual, 1 automatic, 2 cascade"]
    ),
    case!(
        "mode-own-codes.csv",
        "[modes]\n\"16\" = \"auto\"\n\"8\" = \"manual\"",
        Ok("f op 0:50 1:51 mode 0:A 1:M"),
        &[]
    ),
    case!(
        "mode-unknown.csv",
        "",
        Err(()),
        &[
            "row 2, column \"mode\": \"warp\" is not a known mode",
            "mode warp=auto or manual or cascade"
        ]
    ),
    case!(
        "mode-missing.csv",
        "",
        Ok("f op 0:50 1:51 mode 0:A 1:?"),
        &["1 of 2 modes are not recorded"]
    ),
    case!("op-share.csv", "", Ok("f op 0:0.5 1:0.6 (0..1)"), &["OP is between 0 and 1"]),
    case!(
        "op-units.csv",
        "",
        Ok("f op 0:391 1:380 (0..1000)"),
        &["its range is estimated as 0 to 1000"]
    ),
    case!(
        "op-range-given.csv",
        "op_range = [300, 500]\npv_range = [0, 10]",
        Ok("f op 0:391 1:380 (300..500) pv 0:3 1:3 (0..10)"),
        &[]
    ),
    case!(
        "op-milliamps.csv",
        "",
        Ok("f op 0:12 1:13 (0..100)"),
        &["OP is between 12 and 13", "op_range 4,20"]
    ),
    case!("time-iso-z.csv", "", Ok("f @1735689598 op 0:50 1:51"), &[]),
    case!("time-iso-offset.csv", "", Ok("f @1735689598 op 0:50 1:51"), &[]),
    case!("time-compact.csv", "", Ok("f @1735689598 op 0:50 1:51"), &[]),
    case!("time-iso-local.csv", "", Ok("f @1735689598 op 0:50 1:51"), &["the times have no zone"]),
    case!("time-day-first.csv", "", Ok("f @1735689598 op 0:50 1:51"), &["the times have no zone"]),
    case!(
        "time-month-first.csv",
        "",
        Ok("f @1735689598 op 0:50 1:51"),
        &["the times have no zone"]
    ),
    case!("time-month-name.csv", "", Ok("f @1735689598 op 0:50 1:51"), &["the times have no zone"]),
    case!("time-dots.csv", "", Ok("f @1735689598 op 0:50 1:51"), &["the times have no zone"]),
    case!(
        "time-year-slashes.csv",
        "",
        Ok("f @1735689598 op 0:50 1:51"),
        &["the times have no zone"]
    ),
    case!("time-fractions.csv", "", Ok("f @1735689598 op 0:50 0.25:51"), &[]),
    case!("time-epoch-s.csv", "", Ok("f @1735689598 op 0:50 1:51"), &["seconds since 1970"]),
    case!("time-epoch-ms.csv", "", Ok("f @1735689598 op 0:50 1:51"), &["milliseconds since 1970"]),
    case!("time-epoch-us.csv", "", Ok("f @1735689598 op 0:50 1:51"), &["microseconds since 1970"]),
    case!("time-epoch-ns.csv", "", Ok("f @1735689598 op 0:50 1:51"), &["nanoseconds since 1970"]),
    case!(
        "time-excel.csv",
        "",
        Ok("f @1735646400 op 0:50 60:51"),
        &["spreadsheet days since 1900"]
    ),
    case!("time-datenum.csv", "", Ok("f @1735646400 op 0:50 60:51"), &["days of MATLAB's datenum"]),
    case!("time-minutes.csv", "", Ok("f op 0:50 60:51"), &["minutes"]),
    case!(
        "time-dotnet-ticks.csv",
        "",
        Err(()),
        &[
            "as ticks of .NET the sample time would be 1 s from 2024-01-04 on, as nanoseconds since 1970 10 ms from \
             1990-03-25 on",
            "time_format dotnet-ticks or epoch-ns"
        ]
    ),
    case!(
        "time-dotnet-ticks.csv",
        "time_format = \"dotnet-ticks\"",
        Ok("f @1704403200 op 0:50 1:51 2:52"),
        &[]
    ),
    case!(
        "time-filetime.csv",
        "",
        Err(()),
        &[
            "as file time of Windows the sample time would be 1 s, as seconds",
            "time_format filetime or"
        ]
    ),
    case!(
        "time-filetime.csv",
        "time_format = \"filetime\"",
        Ok("f @1705526400 op 0:50 1:51 2:52"),
        &[]
    ),
    case!(
        "time-labview.csv",
        "",
        Err(()),
        &[
            "as seconds since 1904 the sample time would be 1 s from 2024-12-31 on, as seconds since 1970 1 s from \
             2091-01-01 on",
            "time_format labview or epoch-s"
        ]
    ),
    case!(
        "time-labview.csv",
        "time_format = \"labview\"",
        Ok("f @1735603200 op 0:50 1:51 2:52"),
        &[]
    ),
    case!(
        "time-gps.csv",
        "",
        Ok("f @1400000000 op 0:50 1:51 2:52"),
        &["seconds since 1970, from 2014-05-13 on; if they are not, give time_format, such as gps"]
    ),
    case!("time-gps.csv", "time_format = \"gps\"", Ok("f @1715964782 op 0:50 1:51 2:52"), &[]),
    case!(
        "time-days-since-1900.csv",
        "",
        Err(()),
        &[
            "as spreadsheet days since 1900 the sample time would be 60 s from 2024-01-01 on, as days since 1970 60 s from \
             2094-01-02 on",
            "time_format excel,"
        ]
    ),
    case!("time-excel.csv", "time_format = \"excel-1904\"", Ok("f @1861963200 op 0:50 60:51"), &[]),
    case!(
        "time-hourly-in-days.csv",
        "",
        Err(()),
        &[
            "as seconds the sample time would be 42 ms",
            "as days 60 min",
            "time_format seconds or hours or days"
        ]
    ),
    case!(
        "time-hourly-in-days.csv",
        "time_format = \"days\"",
        Ok(
            "f op 0:50 3600.000288:51 7199.999712:52 10800:53 14400.000288:54 17999.999712:55 21600:56 25200.000288000003:57"
        ),
        &[]
    ),
    case!(
        "time-hourly-in-days-5-digits.csv",
        "",
        Err(()),
        &["as seconds the sample time would be 42 ms, as hours", "as days 60 min"]
    ),
    case!(
        "time-seconds-in-minutes.csv",
        "",
        Err(()),
        &["as seconds the sample time would be 17 ms, as minutes 1 s"]
    ),
    case!(
        "time-even-in-seconds.csv",
        "",
        Ok("f op 0:50 0.05:51 0.1:52 0.15:53 0.2:54 0.25:55 0.3:56 0.35:57"),
        &[]
    ),
    case!(
        "time-jitter-in-seconds.csv",
        "",
        Ok(
            "f op 0:50 1.003417:51 2.000981:52 2.99787:53 4.00127:54 5.00391:55 5.9991:56 7.00211:57"
        ),
        &[]
    ),
    case!(
        "cut-in-number.csv",
        "",
        Ok(
            "f op 0:50.125 1:50.25 2:50.375 3:50.5 4:50.625 5:50.75 6:50.875 7:51 8:51.125 9:51.25 10:51"
        ),
        &["the file seems to be cut in row 12", "the last value, \"51\""]
    ),
    case!(
        "cut-in-zeros.csv",
        "",
        Ok(
            "f op 0:45 1:45.03 2:44.95 3:45.15 4:45.05 5:45.08 6:45.12 7:45.2 8:45.17 9:45.13 10:46.41"
        ),
        &["the file seems to be cut in row 12"]
    ),
    case!(
        "whole-without-end.csv",
        "",
        Ok(
            "f op 0:50.125 1:50.25 2:50.375 3:50.5 4:50.625 5:50.75 6:50.875 7:51 8:51.125 9:51.25 10:51.5"
        ),
        &[]
    ),
    case!("time-two-columns.csv", "", Ok("f @1735689598 op 0:50 1:51"), &[]),
    case!(
        "time-pattern.csv",
        "time_format = \"%Hh%M on %d %m %Y\"",
        Ok("f @1735689540 op 0:50"),
        &[]
    ),
    case!("time-and-day.csv", "", Ok("f @1735689598 op 0:50 1:51"), &["\"date\" is not used"]),
    case!(
        "open-quote.csv",
        "",
        Err(()),
        &["row 3, column \"op\": \"51 2,52 3,53\" is not a finite number"]
    ),
    case!(
        "time-pattern-wrong.csv",
        "time_format = \"%H:%M\"",
        Err(()),
        &["row 2, column \"time\": \"noon\" is not a time in the format time_format %H:%M"]
    ),
    case!(
        "time-ambiguous.csv",
        "",
        Err(()),
        &[
            "column \"time\": dates such as \"05/06/2024 00:00\" can be day first or month first",
            "time_format day-first or month-first"
        ]
    ),
    case!(
        "time-ambiguous-told.csv",
        "time_format = \"month-first\"",
        Ok("f @1714953600 op 0:50 60:51"),
        &[]
    ),
    case!("time-decided-late.csv", "", Ok("f @1718236740 op 0:50 60:51"), &[]),
    case!(
        "time-orders-mixed.csv",
        "",
        Err(()),
        &[
            "row 3, column \"time\": \"06/13/2024 00:01\" has a different order of day and month from the rows above"
        ]
    ),
    case!(
        "time-no-day.csv",
        "",
        Err(()),
        &["row 2, column \"time\": \"2023-02-29 00:00\" is not a day of the calendar"]
    ),
    case!(
        "time-empty.csv",
        "",
        Err(()),
        &["row 3, column \"time\": is empty; every row needs a time"]
    ),
    case!(
        "time-words.csv",
        "",
        Err(()),
        &["row 2, column \"time\": \"yesterday\" is not understood as a time", "time_format"]
    ),
    case!("time-half-offset.csv", "", Err(()), &["row 3, column \"time\": has no offset from UTC"]),
    case!(
        "dst-autumn.csv",
        "zone = \"Europe/Berlin\"",
        Ok("f @1729985400 op 0:1 1800:2 3600:3 5400:4 7200:5 9000:6 (0..100)"),
        &["2 rows count as its first pass and 2 as its second"]
    ),
    case!(
        "dst-autumn-newest-first.csv",
        "zone = \"Europe/Berlin\"",
        Ok("f @1729985400 op 9000:6 7200:5 5400:4 3600:3 1800:2 0:1 (0..100)"),
        &[]
    ),
    case!(
        "dst-long.csv",
        "zone = \"Europe/Berlin\"",
        Ok("A @1729989000 op 0:1 2700:2 7200:5 (0..100) pv 0:3 5400:4"),
        &[]
    ),
    case!(
        "dst-spring.csv",
        "zone = \"Europe/Berlin\"",
        Ok("f @1711845000 op 0:1 1800:2 (0..100)"),
        &[]
    ),
    case!(
        "dst-gap.csv",
        "zone = \"Europe/Berlin\"",
        Err(()),
        &[
            "row 3, column \"time\": 2024-03-31T02:30:00 does not exist in Europe/Berlin",
            "zone +01"
        ]
    ),
    case!(
        "dst-unnoticed.csv",
        "",
        Ok("f @1729994400 op 2400:1 3000:2 0:3 600:4 1200:5 (0..100)"),
        &["in row 4 the clock jumps back by exactly an hour", "zone Europe/Berlin"]
    ),
    case!("zone-fixed.csv", "zone = \"+01:00\"", Ok("f @1735689598 op 0:50 1:51"), &[]),
    case!(
        "time-beyond.csv",
        "time_format = \"epoch-s\"",
        Err(()),
        &["is a time beyond the calendar"]
    ),
    case!("time-relative-large.csv", "", Ok("f op 30000:50 30001:51"), &[]),
    case!(
        "time-days-in-t.csv",
        "",
        Err(()),
        &[
            "column \"t\": steps by 0.0000116: as spreadsheet days since 1900 the sample time would be 1 s, \
             as seconds 12 µs",
            "time_format excel or seconds",
            "sample_time 1"
        ]
    ),
    case!(
        "time-days-in-t.csv",
        "time_format = \"excel\"",
        Ok("f @1678838401 op 0:50 1:51 2:52"),
        &["the times have no zone"]
    ),
    case!(
        "time-days-in-t.csv",
        "sample_time = 1",
        Ok("f op 0:50 1:51 2:52"),
        &["\"t\" is not used"]
    ),
    case!(
        "time-datenum-in-t.csv",
        "",
        Err(()),
        &[
            "as days of MATLAB's datenum the sample time would be 1 s, as seconds 12 µs",
            "datenum or seconds"
        ]
    ),
    case!(
        "time-days-or-seconds.csv",
        "",
        Err(()),
        &["column \"time\": steps by 0.5", "sample time would be 12 h", "as seconds 500 ms"]
    ),
    case!(
        "time-days-or-seconds.csv",
        "time_format = \"seconds\"",
        Ok("f op 45000.5:50 45001:51 45001.5:52"),
        &[]
    ),
    case!(
        "time-days-elapsed.csv",
        "",
        Err(()),
        &["as seconds the sample time would be 12 µs, as days 1 s", "time_format seconds or days"]
    ),
    case!(
        "time-epoch-ms-as-s.csv",
        "",
        Err(()),
        &[
            "as milliseconds since 1970 the sample time would be 1 s, as seconds 17 min",
            "epoch-ms or seconds"
        ]
    ),
    case!("time-2-ms.csv", "", Err(()), &["as seconds the sample time would be 2 ms, as days"]),
    case!("time-2-ms.csv", "time_format = \"seconds\"", Ok("f op 0:50 0.002:51 0.004:52"), &[]),
    case!(
        "time-2-days.csv",
        "",
        Err(()),
        &["as seconds the sample time would be 2 d, as milliseconds"]
    ),
    case!("time-2-days.csv", "time_format = \"seconds\"", Ok("f op 0:50 172800:51 345600:52"), &[]),
    case!(
        "time-collapsed.csv",
        "",
        Err(()),
        &[
            "row 3, column \"Timestamp\": has the time \"45000.0001\" of the row before but other values, like 2 \
             of 4 rows",
            "sample_time 1"
        ]
    ),
    case!("time-doubled.csv", "", Ok("f op 0:50 0:50 1:51 1:51"), &[]),
    case!(
        "time-equal.csv",
        "",
        Err(()),
        &["row 3, column \"t\": has the same time \"7\" as all rows before"]
    ),
    case!(
        "time-tiny.csv",
        "",
        Err(()),
        &["column \"t\": steps by 1e-308 s", "which no recording does"]
    ),
    case!("time-digits.csv", "", Err(()), &["row 2, column \"t\"", "is not a time of a recording"]),
    case!(
        "time-far.csv",
        "",
        Err(()),
        &["row 4, column \"time\": \"9999-12-31 00:00:00\"", "is not a time of a recording"]
    ),
    case!(
        "time-gap-endless.csv",
        "",
        Err(()),
        &["row 4, column \"t\": \"1e308\", interpreted as seconds"]
    ),
    case!(
        "sample-time-in-days.csv",
        "",
        Err(()),
        &[
            "interpreted as seconds, would be 12 µs, as days 1 s: if this is right, give sample_time 1"
        ]
    ),
    case!("sample-time-in-days.csv", "sample_time = 1", Ok("f op 0:50 1:51"), &[]),
    case!("sample-time-tiny.csv", "", Err(()), &["given as 1e-308 s, which no recording has"]),
];

#[test]
fn every_file_is_read_or_refused_as_it_should_be() {
    let wrong: Vec<String> = CASES.iter().filter_map(|case| check(case).err()).collect();
    assert!(
        wrong.is_empty(),
        "{}",
        wrong.join(
            "
"
        )
    );
}

fn check(case: &Case) -> Result<(), String> {
    let file = case.file;
    let options =
        ReadOptions::parse(case.mapping, "map.toml").map_err(|e| format!("{file}: {e}"))?;
    let (said, read) = match reading::parse(case.bytes, "f.csv", &options) {
        Ok(reading) => {
            let shown: Vec<_> = reading.recordings.iter().map(recording).collect();
            let notes = reading.recordings.iter().flat_map(|r| &r.notes).chain(&reading.notes);
            (
                notes.cloned().collect::<Vec<_>>().join(
                    "
",
                ),
                Ok(shown.join(" | ")),
            )
        }
        Err(error) => (error.to_string(), Err(())),
    };
    if read.as_deref() != case.read.as_deref() {
        return Err(format!("{file}: {read:?}, expected {:?}; said is {said}", case.read));
    }
    if read.is_err() && !said.starts_with("f.csv") {
        return Err(format!("{file}: the message must name the file: {said}"));
    }
    match case.said.iter().find(|part| !said.contains(**part)) {
        Some(part) => Err(format!("{file} must say {part:?}, but says: {said}")),
        None => Ok(()),
    }
}

proptest! {
    /// A file with some bytes changed, taken out or doubled makes no panic, whatever is said of it.
    #[test]
    fn a_damaged_file_is_read_or_refused(
        file in 0..CASES.len(),
        mapping in 0..CASES.len(),
        changes in proptest::collection::vec((any::<prop::sample::Index>(), 0..3, any::<u8>()), 1..6),
    ) {
        let mut bytes = CASES[file].bytes.to_vec();
        for (place, change, byte) in changes {
            let at = place.index(bytes.len() + 1);
            match change {
                0 => bytes.insert(at, byte),
                1 if at < bytes.len() => bytes[at] = byte,
                _ => {
                    let line: Vec<u8> = bytes.split_off(at);
                    bytes.extend(line.iter().skip(usize::from(byte) % 8));
                }
            }
        }
        let options = ReadOptions::parse(CASES[mapping].mapping, "map.toml").expect("well formed");
        if let Ok(reading) = reading::parse(&bytes, "f.csv", &options) {
            prop_assert!(!reading.recordings.is_empty());
        }
    }
}

/// Every file of the folder is a case.
#[test]
fn no_file_is_forgotten() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/corpus");
    for entry in std::fs::read_dir(folder).expect("the folder") {
        let name = entry.expect("an entry").file_name();
        assert!(CASES.iter().any(|case| *case.file == *name), "{name:?} is no case");
    }
}

fn recording(recording: &Recording) -> String {
    let mut shown = recording.name.clone();
    if recording.loop_type != LoopType::Unknown {
        shown += &format!("({})", recording.loop_type.name());
    }
    if let Some(start) = recording.start {
        shown += &format!(" @{start}");
    }
    shown += &channel("op", Some(&recording.op));
    shown += &channel("pv", recording.pv.as_ref());
    shown += &channel("sp", recording.sp.as_ref());
    shown += &channel("vp", recording.vp.as_ref());
    if let Some(modes) = &recording.mode {
        shown += " mode";
        for (time, mode) in modes.time.iter().zip(&modes.modes) {
            let letter = match mode {
                Mode::Automatic => 'A',
                Mode::Cascade => 'C',
                Mode::Manual => 'M',
                Mode::Other => '?',
            };
            shown += &format!(" {time}:{letter}");
        }
    }
    shown
}

fn channel(name: &str, channel: Option<&Channel>) -> String {
    let Some(channel) = channel else { return String::new() };
    let mut shown = format!(" {name}");
    for ((time, value), quality) in channel.time.iter().zip(&channel.values).zip(&channel.quality) {
        shown += &match quality {
            Quality::Good => format!(" {time}:{value}"),
            Quality::Uncertain => format!(" {time}:{value}?"),
            Quality::Bad => format!(" {time}:b"),
            Quality::Missing => format!(" {time}:m"),
        };
    }
    if let Some(range) = &channel.range {
        shown += &format!(" ({}..{})", range.low, range.high);
    }
    shown
}
