//! Model exchange: a solver from outside finds the events that the library locates itself.

use crate::common;

use common::{Client, Unpacked, reference};
use stiction_fmu::{Fmi, Fmu};
use stiction_model::stem::{EventKind, FrictionLaw, PressureSignal, Stem, StemStart};

/// A fixed-step solver of the fourth order, with events by bisection: as plain as can be.
struct Solver<'a> {
    client: &'a Client,
    states: usize,
    op: fn(f64) -> f64,
}

impl Solver<'_> {
    fn place(&self, time: f64, x: &[f64]) {
        let c = self.client;
        c.good(c.set_time(time));
        c.good(c.set(1, (self.op)(time)));
        c.good(c.set_states(x));
    }

    fn rates(&self, time: f64, x: &[f64]) -> Vec<f64> {
        self.place(time, x);
        let mut rates = vec![f64::NAN; self.states];
        self.client.good(self.client.rates(&mut rates));
        rates
    }

    fn negative(&self, time: f64, x: &[f64]) -> bool {
        self.place(time, x);
        let mut z = [f64::NAN; 6];
        self.client.good(self.client.indicators(&mut z));
        z.iter().any(|z| *z <= 0.0)
    }

    fn step(&self, time: f64, x: &[f64], h: f64) -> Vec<f64> {
        let add = |x: &[f64], k: &[f64], h: f64| -> Vec<f64> {
            x.iter().zip(k).map(|(x, k)| x + h * k).collect()
        };
        let k1 = self.rates(time, x);
        let k2 = self.rates(time + h / 2.0, &add(x, &k1, h / 2.0));
        let k3 = self.rates(time + h / 2.0, &add(x, &k2, h / 2.0));
        let k4 = self.rates(time + h, &add(x, &k3, h));
        (0..x.len()).map(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])).collect()
    }
}

#[test]
fn events_are_found_by_their_indicators() {
    // A lightly damped stem on a slow rise of the OP and back: it moves in steps.
    let fmu = Fmu::new("stem", "cts").unwrap();
    let fmu = fmu.with("viscous_n_s_per_m", 61.29).unwrap().with("VP_start", 0.0).unwrap();
    let op: fn(f64) -> f64 = |t| if t < 60.0 { 100.0 * t / 60.0 } else { 100.0 - 2.0 * (t - 60.0) };
    let end = 100.0;

    let stem = Stem::named("cts").unwrap();
    let FrictionLaw::Classical(law) = *stem.friction() else { unreachable!() };
    let law =
        stiction_model::stem::friction::Classical::new(law.static_n(), law.coulomb_n(), 61.29, 0.0);
    let stem = Stem::new(*stem.parameters(), FrictionLaw::Classical(law.unwrap())).unwrap();
    let p = |t: f64| (t, stem.parameters().pressure_pa(op(t)));
    let signal = PressureSignal::from_points(vec![p(0.0), p(60.0), p(end)]).unwrap();
    let expected = stem.simulate(&signal, StemStart::at_rest(0.0), &[end]).unwrap();

    let events: Vec<_> = expected
        .events
        .iter()
        .map(|e| (e.time_s, matches!(e.kind, EventKind::Stop | EventKind::EndStop)))
        .collect();
    assert!(events.len() > 10, "{events:?}");
    for version in [Fmi::V2, Fmi::V3] {
        let client = Client::instantiate(version, &Unpacked::new(&fmu), true);
        let changes = solved(&fmu, &client, op, end);
        assert_eq!(changes.len(), events.len());
        for ((found, stops), (expected, should_stop)) in changes.iter().zip(&events) {
            assert_eq!(stops, should_stop);
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        }
        let position = client.get(reference(&fmu, "position")).unwrap();
        assert!((position - expected.samples[0].position_m).abs() < 1e-8);
        assert_eq!(client.integer(reference(&fmu, "slips")), expected.slips().count() as i32);
    }
}

/// Solves a stem of two states that begins stuck; when it got stuck or free, and which of these.
fn solved(fmu: &Fmu, client: &Client, op: fn(f64) -> f64, end: f64) -> Vec<(f64, bool)> {
    client.good(client.set(1, op(0.0)));
    client.start();
    let solver = Solver { client, states: 2, op };
    let mut x = vec![0.0; 2];
    let (mut time, mut changes) = (0.0, vec![]);
    let mut stuck = true;
    client.good(client.update());
    client.good(client.enter_continuous_time_mode());
    client.good(client.states(&mut x));
    while time < end {
        let mut h: f64 = if stuck { 0.05 } else { 2e-4 };
        h = h.min(end - time);
        let mut next = solver.step(time, &x, h);
        let event = solver.negative(time + h, &next);
        if event {
            let (mut low, mut high) = (0.0, h);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                let at = solver.step(time, &x, middle);
                if solver.negative(time + middle, &at) { high = middle } else { low = middle }
            }
            h = high;
            next = solver.step(time, &x, h);
        }
        (time, x) = (time + h, next);
        solver.place(time, &x);
        if event {
            client.good(client.enter_event_mode());
            client.good(client.update());
            client.good(client.enter_continuous_time_mode());
            client.good(client.states(&mut x));
            if client.boolean(reference(fmu, "stuck")) != stuck {
                stuck = !stuck;
                changes.push((time, stuck));
            }
        }
    }
    changes
}
