// Every argument that names an output, for the tests of the command and, included there, for those of its arguments.

/// The command or task, the argument, the file or folder that it writes, and a line that does so.
pub type Output = (&'static str, &'static str, &'static str, &'static str);

/// All of them. What a line reads is made by the test `nothing_lost::a_recording_is_replaced_by_no_output`.
pub const OUTPUTS: &[Output] = &[
    ("diagnose", "report", "r.html", "diagnose FIC101-sticky.csv --report r.html"),
    ("diagnose", "csv", "o.csv", "diagnose FIC101-sticky.csv --csv o.csv"),
    ("history", "report", "h.html", "history FIC101-sticky.csv --report h.html"),
    ("history", "csv", "h.csv", "history FIC101-sticky.csv --csv h.csv"),
    ("fit", "output", "f.toml", "fit FIC101-sticky.csv --draws 20 -o f.toml"),
    ("fit", "plot", "f.svg", "fit FIC101-sticky.csv --draws 20 --plot f.svg"),
    ("bench", "csv", "b.csv", "bench simulated 2 --only verdict --csv b.csv"),
    ("bench", "report", "b.html", "bench simulated 2 --only verdict --report b.html"),
    ("bench", "reports", "loops", "bench simulated 2 --only verdict --reports loops"),
    ("suite", "output", "suite", "bench suite v1-trial -o suite"),
    ("report", "output", "b.html", "bench report results.json -o b.html"),
    ("valve", "output", "v.csv", "valve --S 1 --J 1 in.csv -o v.csv"),
    ("stem", "output", "s.csv", "stem -o s.csv"),
    ("stem", "events", "e.csv", "stem -o s.csv --events e.csv"),
    ("simulate", "output", "run.csv", "simulate paper/closed-loop -o run.csv"),
    ("simulate", "plot", "run.svg", "simulate paper/closed-loop --plot run.svg"),
    ("compensate", "csv", "c.csv", "compensate paper/closed-loop --csv c.csv"),
    ("compensate", "plot", "c.svg", "compensate paper/closed-loop --plot c.svg"),
    ("what-if", "csv", "w.csv", "what-if paper/closed-loop --csv w.csv"),
    ("what-if", "plot", "w.svg", "what-if paper/closed-loop --plot w.svg"),
    ("inspect", "write_map", "map.toml", "inspect FIC101-sticky.csv --write-map map.toml"),
    ("plan", "csv", "t.csv", "test plan FIC101-sticky.csv --csv t.csv"),
    ("plan", "sheet", "t.html", "test plan FIC101-sticky.csv --sheet t.html"),
    ("read", "plot", "t.svg", "test read FIC106-tested.csv --plot t.svg"),
    ("read", "report", "t.html", "test read FIC106-tested.csv --report t.html"),
    ("limit-cycle", "csv", "l.csv", "limit-cycle paper/closed-loop --csv l.csv"),
    ("limit-cycle", "plot", "l.svg", "limit-cycle paper/closed-loop --plot l.svg"),
    ("limit-cycle", "nyquist", "n.svg", "limit-cycle paper/closed-loop --nyquist n.svg"),
    ("shift", "csv", "x.csv", "shift FIC101-sticky.csv --csv x.csv"),
    ("fmu", "output", "l.fmu", "fmu paper/closed-loop -o l.fmu"),
    ("population", "output", "people", "population --n 2 -o people"),
    ("demo", "output", "north", "plant demo --loops 1 --days 1 -o north"),
    ("figures", "output", "drawn", "figures -o drawn"),
    ("docs", "output", "site", "docs -o site"),
    ("man", "folder", "pages", "man pages"),
];
