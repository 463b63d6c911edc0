//! A plant of many loops and their windows, made up: for tests, and to try the pages on.

use stiction_plant::WindowRow;

const AREAS: [&str; 5] = ["Crude", "Vacuum", "Reformer", "Utilities", "Tank farm"];
const KINDS: [(&str, &str); 4] =
    [("FIC", "flow"), ("LIC", "level"), ("PIC", "pressure"), ("TIC", "temperature")];
/// Days that windows are made up of.
pub const DAYS: i64 = 28;

/// A number from 0 to 1 that looks like chance, the same for the same `k`.
fn chance(k: usize) -> f64 {
    let mixed = (k as u64)
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .rotate_left(29)
        .wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (mixed >> 11) as f64 / (1u64 << 53) as f64
}

/// Loops that are made up.
pub struct MadeUp {
    /// How many.
    pub loops: usize,
    /// The number of the first.
    pub first_number: usize,
    /// Their first day, of those since 1970.
    pub first_day: i64,
    /// The last days, in which some start to stick and some no longer do.
    pub late_days: i64,
}

impl MadeUp {
    /// The name of loop `k`.
    pub fn name(&self, k: usize) -> String {
        format!("{}{}", KINDS[k % 4].0, self.first_number + k)
    }

    /// What `plant.toml` says of the areas and the loops.
    pub fn plant_toml(&self) -> String {
        let mut text = String::new();
        for (k, area) in AREAS.iter().enumerate() {
            text += &format!("[area.\"{area}\"]\nweight = {}\n", 1 + k % 3);
        }
        for k in 0..self.loops {
            let (name, area) = (self.name(k), AREAS[k * 7 % 31 % 5]);
            let (unit, weight, watch) = (100 + k % 6, 1 + k % 5, k % 50 == 3);
            text += &format!(
                "[loop.{name}]\narea = \"{area}\"\nunit = \"C-{unit}\"\nweight = {weight}\nwatch = {watch}\n"
            );
        }
        text
    }

    /// Their windows, by name and day: a seventh sticks, some of them of late only, some no longer; some loops have an
    /// error, and some nothing at all.
    pub fn rows(&self) -> Vec<WindowRow> {
        let mut rows: Vec<WindowRow> = (0..self.loops)
            .filter(|k| k % 97 != 5)
            .flat_map(|k| (0..DAYS).map(move |day| self.row(k, day)))
            .collect();
        rows.sort_by(|a, b| (&a.name, a.window_start).cmp(&(&b.name, b.window_start)));
        rows
    }

    fn row(&self, k: usize, day: i64) -> WindowRow {
        let late = day >= DAYS - self.late_days;
        let sticks = match k % 14 {
            0 | 1 => true,
            2 if k.is_multiple_of(5) => late,
            3 if k.is_multiple_of(5) => !late,
            _ => false,
        };
        let chance = |n: usize| chance(1000 * k + 10 * day as usize + n);
        let p = if sticks { 0.9 + 0.09 * chance(0) } else { 0.05 + 0.2 * chance(0) };
        let (class, grade) = match p {
            p if p > 0.92 => ("sticks", "sticks"),
            p if p > 0.5 => ("cannot tell", "probably sticks"),
            p if p < 0.1 => ("does not stick", "fine"),
            _ => ("cannot tell", "probably fine"),
        };
        let s = sticks.then(|| {
            (1.0 + (k % 9) as f64) * (1.0 + 0.008 * day as f64) * (1.0 + 0.05 * chance(1))
        });
        let identity = WindowRow {
            name: self.name(k),
            loop_type: KINDS[k % 4].1.to_owned(),
            window_start: (self.first_day + day) * 86_400,
            window_s: 86_400,
            error: (k % 97 == 11).then(|| "its PV has no sample that can be used".to_owned()),
            ..WindowRow::default()
        };
        if identity.error.is_some() {
            return identity;
        }
        let other = ["aggressive tuning", "external oscillation", "normal operation"][k % 3];
        WindowRow {
            samples: Some(8640),
            good_share: Some(100.0),
            auto_share: Some(if k % 89 == 7 { 0.0 } else { 100.0 - 9.0 * chance(2) }),
            stretch_start_s: Some(0.0),
            stretch_s: Some(86_400.0),
            fitness: Some("fit".to_owned()),
            oscillates: Some(!k.is_multiple_of(3) || sticks),
            period_s: Some(60.0 + (k % 50) as f64 * 17.0),
            amplitude: Some(1.0 + chance(3)),
            travel_per_hour: Some(30.0 + 300.0 * chance(4)),
            reversals_per_hour: Some(20.0 + 80.0 * chance(5)),
            at_limit_share: Some(3.0 * chance(6)),
            verdict: Some(class.to_owned()),
            grade: Some(grade.to_owned()),
            probability: Some(p),
            evidence_windows: Some(4.0),
            pool: None,
            s,
            s_low: s.map(|s| 0.9 * s),
            s_high: s.map(|s| 1.1 * s),
            j: s.map(|s| 0.4 * s),
            j_low: s.map(|s| 0.2 * s),
            j_high: s.map(|s| 0.6 * s),
            s_below: (!sticks).then_some(1.2),
            alternative: Some(other.to_owned()),
            alternative_likelihood: Some(0.4 + 0.3 * chance(7)),
            no_response: (k % 83 == 9).then(|| "PV frozen".to_owned()),
            ..identity
        }
    }
}
