//! All keys of each table, for any kind.

type Keys = &'static [&'static str];

pub const SCENARIO: Keys = &[
    "title",
    "sample_time",
    "duration",
    "input",
    "start",
    "valve",
    "controller",
    "process",
    "operating_point",
    "resolution",
    "set_point",
    "noise",
    "measurement",
    "load",
    "manual",
    "master",
];
pub const VALVE: Keys = &["model", "S", "J", "fs", "fd", "K", "rest_tolerance", "limits", "lag"];
pub const CONTROLLER: Keys = &[
    "kc",
    "ti",
    "td",
    "kp",
    "ki",
    "kd",
    "filter",
    "set_point_weight",
    "derivative_on",
    "form",
    "handover",
    "limits",
    "anti_windup",
    "tracking_time",
];
pub const PROCESS: Keys = &["type", "gain", "tau", "tau2", "num", "den", "delay", "dead_time"];
pub const OPERATING_POINT: Keys = &["op", "pv"];
pub const RESOLUTION: Keys = &["op", "pv"];
pub const SIGNAL: Keys = &[
    "signal",
    "value",
    "mean",
    "amplitude",
    "period",
    "phase",
    "steps",
    "start",
    "slope",
    "from",
    "step",
    "dwell",
    "stairs",
    "sd",
    "tau",
    "seed",
    "file",
    "column",
];
pub const MANUAL: Keys = &["from", "until", "change"];
pub const NOISE: Keys = &["sd", "tau", "seed"];
pub const MASTER: Keys =
    &["every", "operating_point", "set_point", "controller", "process", "noise", "measurement"];
