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

/// A file that is read without a mapping.
macro_rules! read {
    ($file:literal, $read:literal $(, $said:literal)*) => {
        case!($file, "", Ok($read), &[$($said),*])
    };
}

/// A file that is refused without a mapping.
macro_rules! refused {
    ($file:literal $(, $said:literal)+) => {
        case!($file, "", Err(()), &[$($said),+])
    };
}

/// The expected readings have the form
/// `NAME(TYPE) @START op TIME:VALUE ... (LOW..HIGH) pv ... mode TIME:MODE ... | NEXT LOOP`, where `b` is a
/// bad value, `m` a missing and `?` an uncertain one.
pub const CASES: &[Case] = &[
    read!("plain.csv", "f op 0:50 1:51 pv 0:1.5 1:1.6"),
    read!("semicolon-comma.csv", "f op 0:50 1:51 pv 0:1.5 1:1.6"),
    read!("tab.tsv", "f op 0:50 1:51 pv 0:1.5 1:1.6"),
    read!("bar.csv", "f op 0:50 1:51 pv 0:1.5 1:1.6"),
    read!("quoted-comma.csv", "f op 0:50 1:51 pv 0:1.5 1:1.6"),
    read!("crlf.csv", "f op 0:50 1:51"),
    read!("bare-cr.csv", "f op 0:50 1:51"),
    read!("mixed-ends.csv", "f op 0:50 1:51"),
    read!("no-last-end.csv", "f op 0:50 1:51"),
    read!("utf8-mark.csv", "f op 0:50 1:51"),
    read!("utf16le.csv", "f op 0:50 1:51"),
    read!("utf16be.csv", "f op 0:50 1:51"),
    read!("utf16-unmarked.csv", "f op 0:50 1:51 pv 0:2 1:3"),
    read!("latin1.csv", "f op 0:50 1:51", "line 1 is not UTF-8"),
    read!("sep-line.csv", "f op 0:50 1:51"),
    read!("blank-lines.csv", "f op 0:50 1:51"),
    read!("trailing-delimiters.csv", "f op 0:50 1:51"),
    read!("trailing-in-rows.csv", "f op 0:50 1:51"),
    read!("spaces.csv", "f op 0:50 1:51"),
    read!("comments.csv", "f op 0:50 1:51", "1 comment lines among the rows"),
    read!("header-in-comment.csv", "f op 0:50 1:51", "the comment in row 1 is used as the header"),
    read!("metadata.csv", "FIC7(flow) op 0:50 1:51 pv 0:1 1:2"),
    read!("units-row.csv", "f op 0:50 1:51 (0..100) pv 0:1 1:2"),
    read!("units-in-brackets.csv", "f op 0:12 1:13 (4..20) pv 0:1 1:2"),
    read!("index-column.csv", "f op 0:50 1:51"),
    read!("sample-time-above.csv", "f op 0:50 5:51 pv 0:1 5:2"),
    read!("upper-case.csv", "f op 0:50 1:51 pv 0:1 1:1 sp 0:2 1:2 vp 0:49 1:49"),
    read!("historian-words.csv", "f op 0:50 1:b 2:b 3:m 4:b 5:m 6:m 7:m 8:b 9:51"),
    case!("own-word.csv", "bad_text = [\"kaputt\"]", Ok("f op 0:50 1:b"), &[]),
    read!("quality-words.csv", "f op 0:50 1:b 2:52?"),
    read!("quality-opc-da.csv", "f op 0:50 1:b 2:52? 3:53", "interpreted as OPC DA codes"),
    read!("quality-opc-ua.csv", "f op 0:50 1:b", "OPC UA status codes"),
    read!("quality-excuses-text.csv", "f op 0:50 1:b"),
    refused!(
        "unknown-word.csv",
        "f.csv, row 3, column \"op\": \"Kaputt\" is neither a number nor a known word",
        "bad_text Kaputt"
    ),
    refused!(
        "quality-unknown.csv",
        "row 2, column \"quality\": \"purple\" is not a known quality",
        "quality purple=good or bad"
    ),
    refused!(
        "quality-undecided.csv",
        "row 2, column \"quality\": 0 is an ambiguous quality code",
        "quality 0=good or bad"
    ),
    case!(
        "quality-decided.csv",
        "[quality]\n\"0\" = \"good\"\n\"1\" = \"bad\"",
        Ok("f op 0:50 1:b"),
        &[]
    ),
    refused!("infinite.csv", "row 3, column \"op\": \"inf\""),
    refused!("too-large.csv", "row 3, column \"op\": \"1e999\" is not a finite number"),
    read!("thousands.csv", "f op 0:50 pv 0:1234.5"),
    refused!(
        "mixed-marks.csv",
        "row 3, column \"op\": \"51,5\" has a decimal \",\", but the other numbers of the file have \".\""
    ),
    refused!(
        "unit-in-cell.csv",
        "row 2, column \"op\": \"50 t/h\" is not a finite number",
        "without units"
    ),
    refused!("empty.csv", "f.csv: is empty; a header row and rows of samples are needed"),
    refused!("only-blank.csv", "is empty"),
    refused!("header-only.csv", "has no row of samples below its header"),
    refused!(
        "headerless.csv",
        "row 1 must name the columns, but reads \"0,50\"; add a header such as \"time,pv,op\""
    ),
    read!(
        "headerless-long.csv",
        "FIC1(flow) @1704067200 op 0:50 1:51",
        "the file has no header; its columns, by their content, are \"tag\", \"time\", \"value\""
    ),
    refused!("short-row.csv", "row 3 has 2 cells, but the header has 3 columns"),
    refused!("long-row.csv", "row 3 has 3 cells, but the header has 2 columns"),
    refused!(
        "same-names.csv",
        "\"op (column 2)\" and \"op (column 3)\" can both be the OP",
        "map op=op (column 2)"
    ),
    case!("same-names.csv", "columns = { \"op (column 3)\" = \"op\" }", Ok("f op 0:1"), &[]),
    refused!("zero-bytes.csv", "line 3 holds a zero byte"),
    refused!("comment-only.csv", "names no columns"),
    refused!("json.json", "f.csv: "),
    refused!("zip.xlsx", "cannot be read as a workbook", "save it as .xlsx again"),
    refused!("gzip.csv.gz", "cannot be unpacked with gzip"),
    read!(
        "influx-annotated.csv",
        "FIC101(flow) @1677916800 op 0:44.97 1:45.02 2:44.98 pv 0:60.06 1:59.96 2:60.03 sp 0:60 1:60 2:60",
        "CSV of InfluxDB with 3 tables; its signals are named by \"_measurement\", \"_field\""
    ),
    read!(
        "influx-tags.csv",
        "FIC101(flow) @1677916800 op 0:45 1:46 pv 0:60 1:b | LIC2(level) @1677916800 op 0:50 1:51 pv 0:1 1:2",
        "with 4 tables; its signals are named by \"id\""
    ),
    read!(
        "influx-pivoted.csv",
        "FIC101(flow) @1677916800 op 0:45 1:46 pv 0:60 1:61 | FIC102(flow) @1677916800 op 0:50 1:51 pv 0:1 1:2",
        "with 2 tables; its signals are named by \"loop\""
    ),
    read!(
        "influx-headers.csv",
        "f @1677916800 op 0:45 1:46 2:47 pv 0:60 1:61 2:62 sp 0:60 1:60 2:60",
        "with 2 tables"
    ),
    refused!(
        "influx-error.csv",
        "row 9 is an error of the query, not a sample: \"runtime error: out of memory\"",
        "export it again"
    ),
    refused!("broken-utf16.csv", "begins like UTF-16LE text"),
    refused!("bad-sample-time.csv", "has \"sample_time: soon\" above the table"),
    refused!(
        "no-op.csv",
        "has no column known as the controller output (OP); its columns are \"t\", \"pv\", \"sp\"",
        "map op=COLUMN"
    ),
    refused!("no-time.csv", "has no column of times", "map time=COLUMN", "sample_time 1"),
    case!("no-time-but-told.csv", "sample_time = 0.5", Ok("f op 0:50 0.5:51 pv 0:1 0.5:2"), &[]),
    refused!("two-ops.csv", "\"op\" and \"output\" can both be the OP", "map op=op"),
    read!(
        "two-times.csv",
        "f op 0:50",
        "\"t\" is used as the time instead of \"timestamp\"",
        "map time=timestamp"
    ),
    read!(
        "mv-alone.csv",
        "f op 0:50 1:51 pv 0:1 1:2",
        "\"mv\" is interpreted as the manipulated variable, the OP",
        "map vp=mv"
    ),
    read!(
        "mv-beside-op.csv",
        "f op 0:50 1:51 vp 0:49 1:49",
        "\"mv\" is beside an OP and is interpreted as the measured valve position"
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
    read!("wide.csv", "FIC1(flow) op 0:50 1:51 pv 0:1 1:2 | LIC2(level) op 0:20 1:21 sp 0:5 1:5"),
    read!(
        "wide-mixed-case.csv",
        "fic1(flow) op 0:50 1:51 pv 0:1 1:2",
        "loop TI5 has no OP and is not read"
    ),
    read!("wide-paths.csv", "A/PIC1/PID1(pressure) op 0:50 1:51 pv 0:1 1:2 mode 0:A 1:M"),
    read!("wide-quality.csv", "TIC1(temperature) op 0:50 1:51 pv 0:1 1:b"),
    read!("one-named-loop.csv", "FIC1(flow) op 0:50 1:51 mode 0:C 1:A"),
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
    read!("long.csv", "FIC1(flow) op 0.5:50 2:b pv 0:1 3:2 mode 0:A"),
    read!(
        "long-historian.csv",
        "FIC1(flow) @1704067200 op 0:50.5 60:b 120:52.5",
        "percent of confidence"
    ),
    refused!("long-unknown-word.csv", "row 3, column \"value\" of \"FIC1.OP\": \"Kaputt\""),
    refused!("long-no-tag.csv", "row 3, column \"tag\": is empty; every row needs a tag"),
    refused!("long-no-op.csv", "has no column known as the controller output", "\"FIC1.PV\""),
    refused!(
        "long-two-values.csv",
        "\"value\" and \"val\" can both be the value",
        "map value=value"
    ),
    refused!(
        "time-not-a-number.csv",
        "row 3, column \"t\": \"later\" is not a number, as this time format requires"
    ),
    read!(
        "mode-codes.csv",
        "f op 0:50 1:51 2:52 mode 0:M 1:A 2:C",
        "mode codes are interpreted as 0 manual, 1 automatic, 2 cascade"
    ),
    case!(
        "mode-own-codes.csv",
        "[modes]\n\"16\" = \"auto\"\n\"8\" = \"manual\"",
        Ok("f op 0:50 1:51 mode 0:A 1:M"),
        &[]
    ),
    refused!(
        "mode-unknown.csv",
        "row 2, column \"mode\": \"warp\" is not a known mode",
        "mode warp=auto or manual or cascade"
    ),
    read!("mode-missing.csv", "f op 0:50 1:51 mode 0:A 1:?", "1 of 2 modes are not recorded"),
    read!("op-share.csv", "f op 0:0.5 1:0.6 (0..1)", "OP is between 0 and 1"),
    read!("op-units.csv", "f op 0:391 1:380 (0..1000)", "its range is estimated as 0 to 1000"),
    case!(
        "op-range-given.csv",
        "op_range = [300, 500]\npv_range = [0, 10]",
        Ok("f op 0:391 1:380 (300..500) pv 0:3 1:3 (0..10)"),
        &[]
    ),
    read!(
        "op-milliamps.csv",
        "f op 0:12 1:13 (0..100)",
        "OP is between 12 and 13",
        "op_range 4,20"
    ),
    read!("time-iso-z.csv", "f @1735689598 op 0:50 1:51"),
    read!("time-iso-offset.csv", "f @1735689598 op 0:50 1:51"),
    read!("time-compact.csv", "f @1735689598 op 0:50 1:51"),
    read!("time-iso-local.csv", "f @1735689598 op 0:50 1:51", "the times have no zone"),
    read!("time-day-first.csv", "f @1735689598 op 0:50 1:51", "the times have no zone"),
    read!("time-month-first.csv", "f @1735689598 op 0:50 1:51", "the times have no zone"),
    read!("time-month-name.csv", "f @1735689598 op 0:50 1:51", "the times have no zone"),
    read!("time-dots.csv", "f @1735689598 op 0:50 1:51", "the times have no zone"),
    read!("time-year-slashes.csv", "f @1735689598 op 0:50 1:51", "the times have no zone"),
    read!("time-fractions.csv", "f @1735689598 op 0:50 0.25:51"),
    read!("time-epoch-s.csv", "f @1735689598 op 0:50 1:51", "seconds since 1970"),
    read!("time-epoch-ms.csv", "f @1735689598 op 0:50 1:51", "milliseconds since 1970"),
    read!("time-epoch-us.csv", "f @1735689598 op 0:50 1:51", "microseconds since 1970"),
    read!("time-epoch-ns.csv", "f @1735689598 op 0:50 1:51", "nanoseconds since 1970"),
    read!("time-excel.csv", "f @1735646400 op 0:50 60:51", "spreadsheet days since 1900"),
    read!("time-datenum.csv", "f @1735646400 op 0:50 60:51", "days of MATLAB's datenum"),
    read!("time-minutes.csv", "f op 0:50 60:51", "minutes"),
    refused!(
        "time-dotnet-ticks.csv",
        "as ticks of .NET the sample time would be 1 s from 2024-01-04 on, as nanoseconds since 1970 10 ms from \
             1990-03-25 on",
        "time_format dotnet-ticks or epoch-ns"
    ),
    case!(
        "time-dotnet-ticks.csv",
        "time_format = \"dotnet-ticks\"",
        Ok("f @1704403200 op 0:50 1:51 2:52"),
        &[]
    ),
    refused!(
        "time-filetime.csv",
        "as file time of Windows the sample time would be 1 s, as seconds",
        "time_format filetime or"
    ),
    case!(
        "time-filetime.csv",
        "time_format = \"filetime\"",
        Ok("f @1705526400 op 0:50 1:51 2:52"),
        &[]
    ),
    refused!(
        "time-labview.csv",
        "as seconds since 1904 the sample time would be 1 s from 2024-12-31 on, as seconds since 1970 1 s from \
             2091-01-01 on",
        "time_format labview or epoch-s"
    ),
    case!(
        "time-labview.csv",
        "time_format = \"labview\"",
        Ok("f @1735603200 op 0:50 1:51 2:52"),
        &[]
    ),
    read!(
        "time-gps.csv",
        "f @1400000000 op 0:50 1:51 2:52",
        "seconds since 1970, from 2014-05-13 on; if they are not, give time_format, such as gps"
    ),
    case!("time-gps.csv", "time_format = \"gps\"", Ok("f @1715964782 op 0:50 1:51 2:52"), &[]),
    refused!(
        "time-days-since-1900.csv",
        "as spreadsheet days since 1900 the sample time would be 60 s from 2024-01-01 on, as days since 1970 60 s from \
             2094-01-02 on",
        "time_format excel,"
    ),
    case!("time-excel.csv", "time_format = \"excel-1904\"", Ok("f @1861963200 op 0:50 60:51"), &[]),
    refused!(
        "time-hourly-in-days.csv",
        "as seconds the sample time would be 42 ms",
        "as days 60 min",
        "time_format seconds or hours or days"
    ),
    case!(
        "time-hourly-in-days.csv",
        "time_format = \"days\"",
        Ok(
            "f op 0:50 3600.000288:51 7199.999712:52 10800:53 14400.000288:54 17999.999712:55 21600:56 25200.000288000003:57"
        ),
        &[]
    ),
    refused!(
        "time-hourly-in-days-5-digits.csv",
        "as seconds the sample time would be 42 ms, as hours",
        "as days 60 min"
    ),
    refused!(
        "time-seconds-in-minutes.csv",
        "as seconds the sample time would be 17 ms, as minutes 1 s"
    ),
    read!(
        "time-even-in-seconds.csv",
        "f op 0:50 0.05:51 0.1:52 0.15:53 0.2:54 0.25:55 0.3:56 0.35:57"
    ),
    read!(
        "time-jitter-in-seconds.csv",
        "f op 0:50 1.003417:51 2.000981:52 2.99787:53 4.00127:54 5.00391:55 5.9991:56 7.00211:57"
    ),
    read!(
        "cut-in-number.csv",
        "f op 0:50.125 1:50.25 2:50.375 3:50.5 4:50.625 5:50.75 6:50.875 7:51 8:51.125 9:51.25 10:51",
        "row 12 seems to be cut short",
        "its last value, \"51\""
    ),
    read!(
        "cut-in-zeros.csv",
        "f op 0:45 1:45.03 2:44.95 3:45.15 4:45.05 5:45.08 6:45.12 7:45.2 8:45.17 9:45.13 10:46.41",
        "row 12 seems to be cut short"
    ),
    read!(
        "whole-without-end.csv",
        "f op 0:50.125 1:50.25 2:50.375 3:50.5 4:50.625 5:50.75 6:50.875 7:51 8:51.125 9:51.25 10:51.5"
    ),
    read!("time-two-columns.csv", "f @1735689598 op 0:50 1:51"),
    case!(
        "time-pattern.csv",
        "time_format = \"%Hh%M on %d %m %Y\"",
        Ok("f @1735689540 op 0:50"),
        &[]
    ),
    read!("time-and-day.csv", "f @1735689598 op 0:50 1:51", "\"date\" is not used"),
    refused!("open-quote.csv", "row 3, column \"op\": \"51 2,52 3,53\" is not a finite number"),
    case!(
        "time-pattern-wrong.csv",
        "time_format = \"%H:%M\"",
        Err(()),
        &["row 2, column \"time\": \"noon\" is not a time in the format time_format %H:%M"]
    ),
    refused!(
        "time-ambiguous.csv",
        "column \"time\": dates such as \"05/06/2024 00:00\" can be day first or month first",
        "time_format day-first or month-first"
    ),
    case!(
        "time-ambiguous-told.csv",
        "time_format = \"month-first\"",
        Ok("f @1714953600 op 0:50 60:51"),
        &[]
    ),
    read!("time-decided-late.csv", "f @1718236740 op 0:50 60:51"),
    refused!(
        "time-orders-mixed.csv",
        "row 3, column \"time\": \"06/13/2024 00:01\" has a different order of day and month from the rows above"
    ),
    refused!(
        "time-no-day.csv",
        "row 2, column \"time\": \"2023-02-29 00:00\" is not a day of the calendar"
    ),
    refused!("time-empty.csv", "row 3, column \"time\": is empty; every row needs a time"),
    refused!(
        "time-words.csv",
        "row 2, column \"time\": \"yesterday\" is not understood as a time",
        "time_format"
    ),
    refused!("time-half-offset.csv", "row 3, column \"time\": has no offset from UTC"),
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
    read!(
        "dst-unnoticed.csv",
        "f @1729994400 op 2400:1 3000:2 0:3 600:4 1200:5 (0..100)",
        "in row 4 the clock jumps back by exactly an hour",
        "zone Europe/Berlin"
    ),
    case!("zone-fixed.csv", "zone = \"+01:00\"", Ok("f @1735689598 op 0:50 1:51"), &[]),
    case!(
        "time-beyond.csv",
        "time_format = \"epoch-s\"",
        Err(()),
        &["is a time beyond the calendar"]
    ),
    read!("time-relative-large.csv", "f op 30000:50 30001:51"),
    refused!(
        "time-days-in-t.csv",
        "column \"t\": steps by 0.0000116: as spreadsheet days since 1900 the sample time would be 1 s, \
             as seconds 12 µs",
        "time_format excel or seconds",
        "sample_time 1"
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
    refused!(
        "time-datenum-in-t.csv",
        "as days of MATLAB's datenum the sample time would be 1 s, as seconds 12 µs",
        "datenum or seconds"
    ),
    refused!(
        "time-days-or-seconds.csv",
        "column \"time\": steps by 0.5",
        "sample time would be 12 h",
        "as seconds 500 ms"
    ),
    case!(
        "time-days-or-seconds.csv",
        "time_format = \"seconds\"",
        Ok("f op 45000.5:50 45001:51 45001.5:52"),
        &[]
    ),
    refused!(
        "time-days-elapsed.csv",
        "as seconds the sample time would be 12 µs, as days 1 s",
        "time_format seconds or days"
    ),
    refused!(
        "time-epoch-ms-as-s.csv",
        "as milliseconds since 1970 the sample time would be 1 s, as seconds 17 min",
        "epoch-ms or seconds"
    ),
    refused!("time-2-ms.csv", "as seconds the sample time would be 2 ms, as days"),
    case!("time-2-ms.csv", "time_format = \"seconds\"", Ok("f op 0:50 0.002:51 0.004:52"), &[]),
    refused!("time-2-days.csv", "as seconds the sample time would be 2 d, as milliseconds"),
    case!("time-2-days.csv", "time_format = \"seconds\"", Ok("f op 0:50 172800:51 345600:52"), &[]),
    refused!(
        "time-collapsed.csv",
        "row 3, column \"Timestamp\": has the time \"45000.0001\" of the row before but other values, like 2 \
             of 4 rows",
        "sample_time 2.88"
    ),
    read!("time-doubled.csv", "f op 0:50 0:50 1:51 1:51"),
    refused!("time-equal.csv", "row 3, column \"t\": has the same time \"7\" as all rows before"),
    refused!("time-tiny.csv", "column \"t\": steps by 1e-308 s", "which is not plausible"),
    refused!("time-digits.csv", "row 2, column \"t\"", "is not a time of a recording"),
    refused!(
        "time-far.csv",
        "row 4, column \"time\": \"9999-12-31 00:00:00\"",
        "is not a time of a recording"
    ),
    refused!("time-gap-endless.csv", "row 4, column \"t\": \"1e308\", interpreted as seconds"),
    refused!(
        "sample-time-in-days.csv",
        "is unusual; give sample_time 1 if it means 1 s (in days), or sample_time"
    ),
    case!("sample-time-in-days.csv", "sample_time = 1", Ok("f op 0:50 1:51"), &[]),
    refused!("sample-time-tiny.csv", "given as 1e-308 s, which is not plausible"),
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
