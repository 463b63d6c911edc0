//! The cases of the gallery: how each is made, what to look at, and what it teaches.

/// A loop of the gallery.
pub struct Case {
    /// Its tag, by which its files are called.
    pub tag: &'static str,
    /// What it is, in a few words.
    pub title: &'static str,
    /// What to look at.
    pub look: &'static str,
    /// What an engineer learns from it.
    pub learn: &'static str,
    /// How it is made.
    pub made: Made,
    /// What it controls, which an engineer knows and tells the diagnosis.
    pub loop_type: &'static str,
}

/// How a case is made.
#[derive(Clone, Copy)]
pub enum Made {
    /// A scenario with some settings, of which these columns are recorded.
    Scenario { name: &'static str, set: &'static [&'static str], columns: &'static str },
    /// A loop of the population, of a kind and with a seed.
    Population { kind: &'static str, seed: u64 },
}

/// What most plants record.
const USUAL: &str = "t,sp,pv,op";

/// All cases, the plain ones first.
pub const CASES: [Case; 12] = [
    Case {
        tag: "FIC201",
        title: "A flow valve that sticks",
        look: "The OP goes up and down in straight lines, the PV jumps from one level to the other: a triangle drives, \
            and a square answers. The controller pushes until the stem breaks away, overshoots, and pushes back.",
        learn: "This is stiction as books show it, in a fast loop with a PI controller and a quiet process. S, told \
            with an interval, is how far the OP has to travel at each turn before the stem moves.",
        made: Made::Scenario { name: "samples/sticky-flow", set: &[], columns: USUAL },
        loop_type: "flow",
    },
    Case {
        tag: "FIC202",
        title: "Tuned too tight",
        look: "A fast cycle, about thirteen seconds, grows and fades as disturbances come. PV and OP are round as far as \
            samples of a second can show it: nothing waits, nothing jumps.",
        learn: "A gain near the ultimate one makes a healthy loop ring after every disturbance. Before a valve is taken out, lower \
            the gain by half: this ringing is gone at once, the cycle of a sticking valve only slows down.",
        made: Made::Scenario { name: "samples/aggressive-flow", set: &[], columns: USUAL },
        loop_type: "flow",
    },
    Case {
        tag: "FIC203",
        title: "A sine from upstream",
        look: "PV and OP are sines of one period, and the OP leads or lags by a fixed angle. The valve follows; another \
            unit makes the load swing.",
        learn: "The loop is the messenger. Look for the same period in its neighbours: whoever swings with the most \
            corners, or first, is the likelier source.",
        made: Made::Scenario { name: "samples/disturbed-flow", set: &[], columns: USUAL },
        loop_type: "flow",
    },
    Case {
        tag: "PIC204",
        title: "A wave with corners from upstream",
        look: "The wave that comes in is no sine: it has corners, as if this valve stuck. The shapes say so, and an S \
            is fitted; but this valve follows.",
        learn: "This is what is taken for stiction most easily: another sticking valve upstream. The verdict stays open \
            and asks for a test, and rightly so. In manual the wave goes on; that of an own sticking valve stops.",
        made: Made::Population { kind: "external wave", seed: 36 },
        loop_type: "self-regulating",
    },
    Case {
        tag: "LIC205",
        title: "A PV in coarse steps",
        look: "The PV moves in steps of a quarter of a percent, with flat pieces between: that is the transmitter's \
            resolution, not a stem at rest.",
        learn: "Flat pieces of a PV prove nothing where it is known in steps only. The price of the steps is told too: \
            a valve that sticks by a few percent would not have shown here.",
        made: Made::Scenario { name: "samples/quantised-level", set: &[], columns: USUAL },
        loop_type: "level",
    },
    Case {
        tag: "LIC206",
        title: "A level whose valve sticks",
        look: "A level integrates what the valve lets through: PV and OP swing alike, a quarter of an hour each time, with \
            pointed tops where the stem lets go, and a pause now and then.",
        learn: "In a level loop even a valve that follows makes PV and OP lag, and methods for flow loops do not apply. \
            Tell what the loop controls, as --type does here. S is not told: its interval is too \
            wide to be a number.",
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
        look: "The set point never rests, because a temperature controller moves it. PV and OP carry that slow \
            wandering, and on top of it the fast cycle of a sticking valve.",
        learn: "A moving set point hides nothing as long as it is recorded: look at the error, not at the PV. The outer \
            loop cycles too, but its valve is this one.",
        made: Made::Scenario { name: "samples/cascade-slave", set: &[], columns: USUAL },
        loop_type: "flow",
    },
    Case {
        tag: "FIC208",
        title: "Only the OP was kept",
        look: "The loop of the first case, of which the historian kept the controller output alone. The triangle of a \
            sticking valve is there, nothing else.",
        learn: "A pattern of the OP is compatible with stiction and proves none: an outer loop or a wave makes the same. \
            So the word stays open whatever the percentage, which is of the pattern alone. Have the PV recorded.",
        made: Made::Scenario { name: "samples/sticky-flow", set: &[], columns: "t,op" },
        loop_type: "flow",
    },
    Case {
        tag: "FIC209",
        title: "A valve that does not respond",
        look: "The OP climbs until it stands at 100 %, and the PV goes down all the same, in steps that the OP did not make.",
        learn: "Something else moves this PV; the valve does not. It is no stick-slip: the stem is seized, shut off or without air. \
            That is another fault than stiction, and it has a word of its own, with what it may be.",
        made: Made::Population { kind: "stuck valve", seed: 3 },
        loop_type: "self-regulating",
    },
    Case {
        tag: "TIC210",
        title: "Sticking that does not show",
        look: "The OP trembles with noise all the time, about as much as the stick band is wide, so the stem never waits long \
            and no cycle builds up. Nothing here says that the valve sticks, but it does.",
        learn: "Fine means fine as far as this record can tell. That is why a limit goes with it: an S above it would \
            have shown, and the true one is below. A quieter day, or small steps in manual, would tell more.",
        made: Made::Population { kind: "sticky valve", seed: 5 },
        loop_type: "self-regulating",
    },
    Case {
        tag: "FIC211",
        title: "The valve position is recorded",
        look: "The loop of the sine from upstream, now with a valve that sticks a little. PV and OP look much as they did; the \
            position stands still at each turn, and then jumps.",
        learn: "A positioner's feedback settles what PV and OP alone leave open: without the column vp this record is unclear. S is \
            within a tenth of the true one. If your positioners know their position, have it in the historian.",
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
        look: "At every step of the set point the PV follows at once and settles; small moves of the OP between them are \
            answered too.",
        learn: "Set-point steps are the best test that nobody had to make: a valve that sticks stops short of them, and \
            this one does not. So it is cleared, with a limit.",
        made: Made::Population { kind: "set-point changes", seed: 23 },
        loop_type: "self-regulating",
    },
];
