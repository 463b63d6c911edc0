//! The coherence of all pairs of loops, the part of the search that grows with the square of their number. It can be done in
//! blocks on other machines, with the same result to the last bit.

use super::bank::{self, Pieces, Series};
use super::coherence::coherence;
use super::{GroupOptions, LoopOfWeek};
use crate::store::trace::Trace;
use crate::store::window::ENGINE_VERSION;
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

pub use crate::store::pair::Pair;

/// A pair with a larger probability in its band cannot count, and is left out.
const TOLD: f64 = 0.05;

/// Loops on one clock, by name, and the bands in which each loop swings.
pub struct Swings {
    /// Their signals.
    pub series: Vec<Series>,
    /// The power of each in every band.
    pub powers: Vec<Vec<f64>>,
    peaks: Vec<BTreeSet<usize>>,
}

/// A [`Pair`], by the places of its loops.
#[derive(Debug, Clone, Copy)]
pub struct Edge {
    /// Band.
    pub band: usize,
    /// The first by name first.
    pub pair: (usize, usize),
    /// Probability by chance.
    pub p: f64,
    /// Squared coherence.
    pub squared: f64,
}

/// The first and the last instant of some traces, s since 1970-01-01 UTC.
pub fn span(traces: &[Trace]) -> Range<i64> {
    let from = traces.iter().map(|trace| trace.start).min().unwrap_or(0);
    from..traces.iter().map(Trace::end).max().unwrap_or(0)
}

impl Swings {
    /// Of traces within a span, and the other facts about the loops.
    pub fn of<'a>(
        traces: impl IntoIterator<Item = &'a Trace>,
        loops: &[LoopOfWeek],
        span: &Range<i64>,
    ) -> Self {
        let series = bank::series(traces, span);
        let powers: Vec<Vec<f64>> = series.par_iter().map(Series::powers).collect();
        let told: BTreeMap<&str, f64> =
            loops.iter().filter_map(|own| Some((&*own.name, own.period_s?))).collect();
        let of = |(series, powers): (&Series, &Vec<f64>)| {
            let told = told.get(&*series.name).and_then(|period| bank::band_of(1.0 / period));
            bank::peaks(powers).into_iter().chain(told).collect()
        };
        let peaks = series.iter().zip(&powers).map(of).collect();
        Self { series, powers, peaks }
    }

    /// The coherence of pairs in the bands in which one of the two swings, by band, then by loops. Only wanted pairs, by the
    /// places of their loops.
    pub fn edges(&self, asked: impl Fn(usize, usize) -> bool + Sync) -> Vec<Edge> {
        let (series, peaks) = (&self.series, &self.peaks);
        let wanted: BTreeSet<usize> = peaks.iter().flatten().copied().collect();
        let mut edges = vec![];
        // A level at a time, so that few pieces are in memory.
        for level in bank::levels(&wanted) {
            let pieces: Vec<Vec<Pieces>> =
                series.par_iter().map(|own| own.pieces(&level)).collect();
            for (at, band) in level.iter().enumerate() {
                let swings = |k: usize| peaks[k].contains(band);
                let found: Vec<Vec<Edge>> = (0..series.len())
                    .into_par_iter()
                    .map(|b| {
                        let others = (0..b).filter(|a| (swings(*a) || swings(b)) && asked(*a, b));
                        let edge = |a: usize| {
                            let cycles = bank::frequency(*band) * series[a].seconds();
                            let found = coherence(&pieces[a][at], &pieces[b][at], cycles)?;
                            // The best of several bands is more likely by chance, by the number of bands.
                            let times = peaks[a].union(&peaks[b]).count() as f64;
                            let p = found.p * times;
                            let edge =
                                Edge { band: *band, pair: (a, b), p, squared: found.squared };
                            (found.p < TOLD).then_some(edge)
                        };
                        others.filter_map(edge).collect()
                    })
                    .collect();
                edges.extend(found.into_iter().flatten());
            }
        }
        edges
    }

    /// The edges from pairs found earlier, in the same order; `None` if the loop of a pair is missing.
    pub fn edges_of(&self, pairs: &[Pair]) -> Option<Vec<Edge>> {
        let place = |name: &str| self.series.binary_search_by(|own| (*own.name).cmp(name)).ok();
        let edge = |pair: &Pair| {
            let of = (place(&pair.first)?, place(&pair.second)?);
            let band = usize::try_from(pair.band).ok().filter(|band| *band < bank::BANDS)?;
            Some(Edge { band, pair: of, p: pair.p, squared: pair.squared })
        };
        let mut edges: Vec<Edge> = pairs.iter().map(edge).collect::<Option<_>>()?;
        edges.sort_by_key(|edge| (edge.band, edge.pair.1, edge.pair.0));
        Some(edges)
    }
}

/// The pairs among the loops of some traces. With `block`, a set of names, only pairs of a loop in it and a
/// loop outside. `span` is the time range of all traces, including missing ones.
pub fn pairs(
    traces: &[Trace],
    loops: &[LoopOfWeek],
    span: &Range<i64>,
    block: Option<&BTreeSet<String>>,
) -> Vec<Pair> {
    let swings = Swings::of(traces, loops, span);
    let name = |k: usize| &swings.series[k].name;
    let edges = match block {
        None => swings.edges(|_, _| true),
        Some(block) => {
            let is_in: Vec<bool> =
                swings.series.iter().map(|own| block.contains(&own.name)).collect();
            swings.edges(|a, b| is_in[a] != is_in[b])
        }
    };
    let told = |edge: &Edge| Pair {
        first: name(edge.pair.0).clone(),
        second: name(edge.pair.1).clone(),
        band: edge.band as i64,
        p: edge.p,
        squared: edge.squared,
    };
    edges.iter().map(told).collect()
}

/// A bound on the probability of all accepted pairs, if `count` pairs of these loops are as improbable as the last
/// accepted pair. Applied again to the rest, it approaches the pairs that count.
pub fn most_that_counts(count: usize, loops: usize, options: &GroupOptions) -> f64 {
    options.false_discovery_rate * count as f64 / all_pairs(loops) as f64
}

/// The number of pairs of some loops.
pub fn all_pairs(loops: usize) -> usize {
    loops * loops.saturating_sub(1) / 2
}

/// SHA-256 of everything from which pairs are computed.
pub fn made_of(traces: &[Trace], loops: &[LoopOfWeek]) -> String {
    let mut digest = Sha256::new();
    let mut add = |text: &str| {
        digest.update((text.len() as u64).to_le_bytes());
        digest.update(text);
    };
    add(ENGINE_VERSION);
    for trace in traces {
        add(&trace.name);
        add(&format!("{} {} {:x}", trace.start, trace.signal.name(), trace.unit.to_bits()));
        add(&trace.digest());
    }
    for own in loops.iter().filter(|own| own.period_s.is_some()) {
        add(&own.name);
        add(&format!("{:?}", own.period_s));
    }
    format!("{:x}", digest.finalize())
}
