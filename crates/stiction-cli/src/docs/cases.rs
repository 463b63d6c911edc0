//! The cases of the gallery, with hints and conclusions.

/// A loop of the gallery.
pub struct Case {
    /// Tag, also the name of its files.
    pub tag: &'static str,
    /// A short title.
    pub title: &'static str,
    /// What the figures show.
    pub look: &'static str,
    /// What an engineer learns from it.
    pub learn: &'static str,
    /// How it is made.
    pub made: Made,
    /// The type of the loop, which an engineer knows and passes to the diagnosis.
    pub loop_type: &'static str,
}

/// How a case is made.
#[derive(Clone, Copy)]
pub enum Made {
    /// A scenario with some settings and the columns to record.
    Scenario { name: &'static str, set: &'static [&'static str], columns: &'static str },
    /// A loop of the population of this kind and seed.
    Population { kind: &'static str, seed: u64 },
}

/// The signals that most plants record.
const USUAL: &str = "t,sp,pv,op";

/// All cases, simple ones first.
pub const CASES: [Case; 12] = [
    Case {
        tag: "FIC201",
        title: "A flow valve that sticks",
        look: "The OP moves up and down in straight lines, while the PV jumps between two levels. A triangular OP \
            with a square PV is typical of stiction. The controller pushes until the stem breaks away, overshoots, \
            and pushes back.",
        learn: "This is textbook stiction, in a fast loop with a PI controller and a quiet process. S is the OP \
            travel needed after each reversal before the stem moves, reported with an interval.",
        made: Made::Scenario { name: "samples/sticky-flow", set: &[], columns: USUAL },
        loop_type: "flow",
    },
    Case {
        tag: "FIC202",
        title: "Tuned too tight",
        look: "A fast cycle of about 13 s grows and fades with the disturbances. At a sample time of 1 s, \
            PV and OP look round, without pauses or jumps.",
        learn: "A gain near the ultimate gain makes a healthy loop ring after every disturbance. Halve the gain \
            before you take a valve out. With half the gain this ringing stops at once, while the cycle of a sticking \
            valve only becomes slower.",
        made: Made::Scenario { name: "samples/aggressive-flow", set: &[], columns: USUAL },
        loop_type: "flow",
    },
    Case {
        tag: "FIC203",
        title: "A sine from upstream",
        look: "PV and OP are sines of the same period, with a constant phase shift. The valve follows. Another unit \
            makes the load swing.",
        learn: "This loop only passes the oscillation on. Look for the same period in neighbouring loops. The likelier \
            source is the loop with the sharpest corners, or the loop that swings first.",
        made: Made::Scenario { name: "samples/disturbed-flow", set: &[], columns: USUAL },
        loop_type: "flow",
    },
    Case {
        tag: "PIC204",
        title: "A wave with corners from upstream",
        look: "The incoming wave is not a sine. The wave has corners, as if this valve stuck. The wave shapes indicate \
            stiction and an S is fitted, but this valve follows its OP.",
        learn: "A sticking valve upstream is the cause most easily mistaken for stiction in this valve. The verdict rightly \
            stays open and asks for a test. With the controller in manual, the wave continues. In manual, a \
            cycle caused by this valve would stop.",
        made: Made::Population { kind: "external wave", seed: 36 },
        loop_type: "self-regulating",
    },
    Case {
        tag: "LIC205",
        title: "A PV in coarse steps",
        look: "The PV moves in steps of a quarter of a percent, with flat pieces between. The cause is the \
            transmitter's resolution, not a stem at rest.",
        learn: "Flat pieces prove nothing if the PV has only coarse steps. The report shows what the steps mask: a \
                valve with an S of a few percent would not have been detected here.",
        made: Made::Scenario { name: "samples/quantised-level", set: &[], columns: USUAL },
        loop_type: "level",
    },
    Case {
        tag: "LIC206",
        title: "A level whose valve sticks",
        look: "A level integrates the flow through the valve. PV and OP swing with the same period of a quarter of an \
            hour. Both have pointed tops where the stem slips, and occasional pauses.",
        learn: "In a level loop, the PV lags the OP even with a healthy valve, so methods for flow loops do not \
            apply. State what the loop controls, as --type does here. S is not reported because its interval is too \
            wide.",
        made: Made::Scenario {
            name: "samples/quantised-level",
            set: &[
                "valve.model=\"two-phase\"",
                "valve.S=4",
                "valve.J=2",
                "resolution.pv=0.02",
                "noise.sd=0.02",
                "load.0.sd=1",
                "duration=28800",
            ],
            columns: USUAL,
        },
        loop_type: "level",
    },
    Case {
        tag: "FIC207",
        title: "The inner loop of a cascade",
        look: "The set point never rests, because a temperature controller moves it. PV and OP follow the slow \
            set point, and the fast cycle of a sticking valve is superimposed.",
        learn: "A moving set point masks nothing if the set point is recorded. Look at the control error, not at the \
            PV. The outer loop cycles too, but this valve is the cause.",
        made: Made::Scenario { name: "samples/cascade-slave", set: &[], columns: USUAL },
        loop_type: "flow",
    },
    Case {
        tag: "FIC208",
        title: "Only the OP was kept",
        look: "This is the loop of the first case, but the historian kept only the controller output. Only the \
            triangle of a sticking valve is visible.",
        learn: "A pattern of the OP is compatible with stiction but does not prove it, because an outer loop or an \
            external wave makes the same pattern. The verdict therefore stays open, even if the pattern gives a high probability. Have the PV \
            recorded.",
        made: Made::Scenario { name: "samples/sticky-flow", set: &[], columns: "t,op" },
        loop_type: "flow",
    },
    Case {
        tag: "FIC209",
        title: "A valve that does not respond",
        look: "The OP rises to 100 % and stays there, while the PV still falls, in steps that the OP did not make.",
        learn: "Something other than the valve moves this PV. This is not stick-slip. The valve is seized, shut off or \
                without air. The verdict for such faults is \"does not respond\", with a list of possible faults.",
        made: Made::Population { kind: "stuck valve", seed: 3 },
        loop_type: "self-regulating",
    },
    Case {
        tag: "TIC210",
        title: "Sticking that is masked",
        look: "The OP noise is constant and about as large as the stick band, so the stem never waits long and no \
            cycle builds up. The valve sticks, but this record does not show it.",
        learn: "The verdict \"fine\" covers only what this record can show. The report therefore adds a detection limit: an S \
            above the limit would have been detected, and the true S is below the limit. A quieter day, or small steps in manual, \
            would lower the limit.",
        made: Made::Population { kind: "sticky valve", seed: 5 },
        loop_type: "self-regulating",
    },
    Case {
        tag: "FIC211",
        title: "The valve position is recorded",
        look: "This is the loop with the sine from upstream, but here the valve sticks a little. PV and OP look \
            nearly the same. The position stands still at each reversal and then jumps.",
        learn: "The measured valve position decides cases that PV and OP alone leave open. Without the column vp this record \
            is unclear. S is within a tenth of the true value. If your positioners measure the position, record it \
            in the historian.",
        made: Made::Scenario {
            name: "samples/disturbed-flow",
            set: &["valve.model=\"two-phase\"", "valve.S=2", "valve.J=1", "valve.lag=1"],
            columns: "t,sp,pv,op,vp",
        },
        loop_type: "flow",
    },
    Case {
        tag: "FIC212",
        title: "Healthy, with a set point that moves",
        look: "At every step of the set point the PV follows at once and settles. The PV also follows small moves of \
            the OP between the steps.",
        learn: "Set-point steps are a test at no cost. A sticking valve would not follow such small moves, and this valve does. \
            So the valve is cleared, with a detection limit.",
        made: Made::Population { kind: "set-point changes", seed: 23 },
        loop_type: "self-regulating",
    },
];
