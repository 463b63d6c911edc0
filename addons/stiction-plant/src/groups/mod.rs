//! Loops that swing together, and which of them may be the source.
//!
//! ```text
//! traces of a week ──> bands (bank) ──> peaks of each loop ──> coherence of each pair there (pairs) ──> p
//!     p of all pairs, at a false discovery rate ──> edges ──> groups of one period ──> their common swing
//!     probability, shape, upstream ──> candidates for the source, in their order
//! ```
//! The loops of a group swing in step. Of all pairs that are reported, one in twenty does so by chance. The members are ranked
//! as candidates for the source, with reasons. The source is not decided, because it may not be recorded.

mod bank;
pub mod coherence;
pub mod pairs;

use crate::store::trace::Trace;
use bank::{BANDS, Pieces, Series};
use coherence::threshold;
use pairs::{Edge, Pair, Swings, all_pairs, span};
use realfft::num_complex::Complex;
use std::collections::{BTreeMap, BTreeSet};
use stiction_diagnose::spoken::{self, counted};

/// Loops that swing together, and the candidates for the source.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Group {
    /// Number of the group, from 1.
    pub id: usize,
    /// Period of the swing, s.
    pub period_s: f64,
    /// The loops of the group: first the candidates for the source by rank, then the other loops by coherence.
    pub members: Vec<Member>,
    /// Whether a loop of the group may be the source.
    pub source: Source,
    /// The evidence for the group, in sentences.
    pub reasons: Vec<String>,
}

/// A loop of a group of loops that swing together.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Member {
    /// Tag of the loop.
    #[serde(rename = "loop")]
    pub name: String,
    /// Probability that its valve sticks; in the ranking, not in documents.
    #[serde(skip)]
    pub probability: Option<f64>,
    /// The share of the loop's swing at the period that is common to the group: squared coherence, 0 to 1.
    pub coherence: f64,
    /// Rank among the candidates for the source, from 1; `None` if the loop is no candidate.
    pub candidate_rank: Option<usize>,
    /// Evidence for and against this loop as the source, in sentences.
    pub reasons: Vec<String>,
}

/// Where the source of a group may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Source {
    /// Among the members; they are ranked.
    Candidates,
    /// Not among the recorded loops: none of their valves is likely to stick.
    NotRecorded,
}

/// A loop in a week.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LoopOfWeek {
    /// Tag.
    pub name: String,
    /// Probability that its valve sticks.
    pub probability: Option<f64>,
    /// Period of its oscillation, s.
    pub period_s: Option<f64>,
}

/// How groups are found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroupOptions {
    /// The share of the reported pairs that may swing together by chance.
    pub false_discovery_rate: f64,
    /// The least squared coherence of a pair. Below it, most of the swing has other reasons.
    pub least_coherence: f64,
    /// The least probability of sticking of a candidate for the source.
    pub least_probability: f64,
    /// The source is among the members only if one of them sticks with this probability.
    pub likely: f64,
}

impl Default for GroupOptions {
    fn default() -> Self {
        Self {
            false_discovery_rate: 0.05,
            least_coherence: 0.3,
            least_probability: 0.02,
            likely: 0.2,
        }
    }
}

/// The groups of some traces, the largest first. `loops` contains the other facts about the loops. `upstream` lists,
/// for a given loop, the loops whose swing would reach it. Traces may have gaps. The result is the same on any number
/// of threads.
pub fn find(
    traces: &[Trace],
    loops: &[LoopOfWeek],
    upstream: &BTreeMap<String, Vec<String>>,
    options: &GroupOptions,
) -> Vec<Group> {
    let swings = Swings::of(traces, loops, &span(traces));
    let edges = swings.edges(|_, _| true);
    find_among(&swings, edges, swings.series.len(), loops, upstream, options)
}

/// The groups of some traces, from pairs found earlier. All accepted pairs must be present.
///
/// `None` if one is of a loop that has no trace.
pub fn find_of(
    pairs: &[Pair],
    traces: &[Trace],
    loops: &[LoopOfWeek],
    upstream: &BTreeMap<String, Vec<String>>,
    options: &GroupOptions,
) -> Option<Vec<Group>> {
    // Of the others only their number counts.
    let named: BTreeSet<&str> =
        pairs.iter().flat_map(|pair| [&*pair.first, &*pair.second]).collect();
    let all: BTreeSet<&str> = traces.iter().map(|trace| &*trace.name).collect();
    let own = traces.iter().filter(|trace| named.contains(&*trace.name));
    let swings = Swings::of(own, loops, &span(traces));
    let edges = swings.edges_of(pairs)?;
    Some(find_among(&swings, edges, all.len(), loops, upstream, options))
}

/// The groups that edges between some of `all` loops make.
fn find_among(
    swings: &Swings,
    mut edges: Vec<Edge>,
    all: usize,
    loops: &[LoopOfWeek],
    upstream: &BTreeMap<String, Vec<String>>,
    options: &GroupOptions,
) -> Vec<Group> {
    let mut best: BTreeMap<(usize, usize), f64> = BTreeMap::new();
    for edge in &edges {
        let p = best.entry(edge.pair).or_insert(1.0);
        *p = p.min(edge.p);
    }
    let best = best.into_values().collect();
    let limit = threshold(best, all_pairs(all), options.false_discovery_rate);
    edges.retain(|edge| edge.p <= limit && edge.squared >= options.least_coherence);
    let known = loops.iter().map(|own| (&*own.name, own)).collect();
    let context =
        Context { series: &swings.series, powers: &swings.powers, known, upstream, options };
    let mut groups: Vec<Group> = one_a_swing(components(&edges))
        .into_iter()
        .filter_map(|part| context.group(&part))
        .collect();
    groups.sort_by(|a, b| {
        b.members.len().cmp(&a.members.len()).then(a.period_s.total_cmp(&b.period_s))
    });
    groups.iter_mut().enumerate().for_each(|(k, group)| group.id = k + 1);
    groups
}

/// Loops in bands, with the edges between them.
#[derive(Debug, Default)]
struct Part {
    loops: BTreeSet<usize>,
    edges: Vec<Edge>,
}

impl Part {
    /// The band that most of the coherence is in.
    fn band(&self) -> usize {
        let mut sums = [0.0; BANDS];
        self.edges.iter().for_each(|edge| sums[edge.band] += edge.squared);
        (0..BANDS).fold(0, |a, b| if sums[b] > sums[a] { b } else { a })
    }
}

/// The connected parts: by an edge, or by a loop with edges in two adjacent bands.
fn components(edges: &[Edge]) -> Vec<Part> {
    let mut nodes: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    for edge in edges {
        for k in [edge.pair.0, edge.pair.1] {
            let next = nodes.len();
            nodes.entry((k, edge.band)).or_insert(next);
        }
    }
    let mut parent: Vec<usize> = (0..nodes.len()).collect();
    fn root(parent: &mut [usize], mut k: usize) -> usize {
        while parent[k] != k {
            parent[k] = parent[parent[k]];
            k = parent[k];
        }
        k
    }
    let mut unite = |a: usize, b: usize| {
        let (a, b) = (root(&mut parent, a), root(&mut parent, b));
        parent[a.max(b)] = a.min(b);
    };
    for edge in edges {
        unite(nodes[&(edge.pair.0, edge.band)], nodes[&(edge.pair.1, edge.band)]);
    }
    for ((k, band), node) in &nodes {
        if let Some(beside) = nodes.get(&(*k, band + 1)) {
            unite(*node, *beside);
        }
    }
    let mut parts: BTreeMap<usize, Part> = BTreeMap::new();
    for edge in edges {
        let at = root(&mut parent, nodes[&(edge.pair.0, edge.band)]);
        let part = parts.entry(at).or_default();
        part.loops.extend([edge.pair.0, edge.pair.1]);
        part.edges.push(*edge);
    }
    parts.into_values().collect()
}

/// Removes parts that show the same swing again. Such parts share nearly all loops, or half of their loops at nearly
/// the same period or a fraction of it. The part with the largest coherence is kept.
fn one_a_swing(mut parts: Vec<Part>) -> Vec<Part> {
    let strength = |part: &Part| part.edges.iter().map(|edge| edge.squared).sum::<f64>();
    parts.sort_by(|a, b| strength(b).total_cmp(&strength(a)).then(a.loops.cmp(&b.loops)));
    let mut kept: Vec<Part> = vec![];
    for part in parts {
        let again = |other: &Part| {
            let ratio = bank::frequency(part.band()) / bank::frequency(other.band());
            let ratio = ratio.max(1.0 / ratio);
            let of_it = ratio < 1.6 || (ratio / ratio.round() - 1.0).abs() < 0.13;
            let shared = part.loops.intersection(&other.loops).count();
            let (fewer, more) =
                (part.loops.len().min(other.loops.len()), part.loops.union(&other.loops).count());
            3 * shared >= 2 * more || of_it && 2 * shared >= fewer
        };
        if !kept.iter().any(again) {
            kept.push(part);
        }
    }
    kept
}

/// The facts from which groups are formed.
struct Context<'a> {
    series: &'a [Series],
    powers: &'a [Vec<f64>],
    known: BTreeMap<&'a str, &'a LoopOfWeek>,
    upstream: &'a BTreeMap<String, Vec<String>>,
    options: &'a GroupOptions,
}

impl Context<'_> {
    /// The group of a part; `None` if fewer than two loops have the common swing.
    fn group(&self, part: &Part) -> Option<Group> {
        let band = part.band();
        let loops: Vec<usize> = part.loops.iter().copied().collect();
        let pieces: Vec<Pieces> =
            loops.iter().filter_map(|k| self.series[*k].pieces(&[band]).pop()).collect();
        let common = common_swing(&pieces);
        let (loops, common): (Vec<usize>, Vec<f64>) = loops
            .into_iter()
            .zip(common)
            .filter(|(_, shared)| *shared >= self.options.least_coherence)
            .unzip();
        if loops.len() < 2 {
            return None;
        }
        let names: BTreeSet<&str> = loops.iter().map(|k| &*self.series[*k].name).collect();
        let shapes: Vec<f64> = loops.iter().map(|k| self.series[*k].shape(band)).collect();
        let sharpest = shapes.iter().copied().fold(0.0, f64::max);
        let mut told: Vec<(f64, Option<f64>, Member)> = vec![];
        for ((k, shared), shape) in loops.iter().zip(&common).zip(&shapes) {
            let name = &self.series[*k].name;
            let probability = self.known.get(&**name).and_then(|own| own.probability);
            let mut reasons = vec![match probability {
                Some(p) => {
                    format!("The valve sticks with a probability of {}.", spoken::percent(p))
                }
                None => "It is unknown whether the valve sticks.".to_owned(),
            }];
            let mut score = logit(probability.unwrap_or(UNKNOWN));
            if sharpest > SHARP && *shape == sharpest {
                score += VOTE;
                reasons.push("This swing is the least like a sine.".to_owned());
            }
            let above = |of: &str| {
                let list = self.upstream.get(of).map_or(&[][..], Vec::as_slice);
                list.iter().filter(|other| names.contains(&***other)).cloned().collect::<Vec<_>>()
            };
            let own = above(name);
            if !own.is_empty() {
                score -= VOTE;
                reasons.push(format!("Upstream in the group: {}.", own.join(", ")));
            }
            let reaches = names.iter().filter(|other| above(other).contains(name)).count();
            if reaches > 0 && own.is_empty() {
                score += VOTE;
                reasons
                    .push(format!("The loop is upstream of {}.", counted(reaches, "other loop")));
            }
            let coherence = *shared;
            let name = name.clone();
            let member = Member { name, probability, coherence, candidate_rank: None, reasons };
            told.push((score, probability, member));
        }
        let likely = |p: Option<f64>| p.is_none_or(|p| p >= self.options.likely);
        let source = match told.iter().any(|(_, p, _)| likely(*p)) {
            true => Source::Candidates,
            false => Source::NotRecorded,
        };
        let candidate = |p: Option<f64>| p.is_none_or(|p| p >= self.options.least_probability);
        told.sort_by(|a, b| {
            (candidate(b.1).cmp(&candidate(a.1)))
                .then(b.0.total_cmp(&a.0))
                .then(b.2.coherence.total_cmp(&a.2.coherence))
                .then(a.2.name.cmp(&b.2.name))
        });
        if source == Source::Candidates {
            for (k, (_, p, member)) in told.iter_mut().enumerate() {
                member.candidate_rank = candidate(*p).then_some(k + 1);
            }
        }
        let period_s = self.period(&loops, band);
        let members: Vec<Member> = told.into_iter().map(|(.., member)| member).collect();
        let mut reasons =
            vec![format!("{} loops swing together {}.", members.len(), period(period_s))];
        if source == Source::NotRecorded {
            reasons.push("None of the valves is likely to stick.".to_owned());
        }
        Some(Group { id: 0, period_s, members, source, reasons })
    }

    /// The period of a swing: the centre of the power of all in the band and those beside it, s.
    fn period(&self, loops: &[usize], band: usize) -> f64 {
        let (mut moment, mut weight) = (0.0, 0.0);
        for k in loops {
            let about = band.saturating_sub(1)..(band + 2).min(BANDS);
            let all: f64 =
                about.clone().map(|b| self.powers[*k][b]).filter(|p| p.is_finite()).sum();
            for b in about.filter(|b| self.powers[*k][*b].is_finite()) {
                moment += self.powers[*k][b] / all * bank::frequency(b).ln();
                weight += self.powers[*k][b] / all;
            }
        }
        (-moment / weight).exp()
    }
}

/// The probability if none is known.
const UNKNOWN: f64 = 0.2;
/// The value of a vote, added to the logit of the probability.
const VOTE: f64 = 1.0;
/// The least share of the power in harmonics of a swing that is not a sine.
const SHARP: f64 = 0.02;

fn logit(p: f64) -> f64 {
    let p = p.clamp(0.005, 0.995);
    (p / (1.0 - p)).ln()
}

/// The squared coherence of each loop with the common swing. It is the largest eigenvalue of the coherence matrix,
/// times the square of the loop's element in the eigenvector. After the spectral envelope and oscillation contribution
/// index of Jiang, Choudhury and Shah (2007), at one frequency.
fn common_swing(pieces: &[Pieces]) -> Vec<f64> {
    let n = pieces.len();
    let product = |x: &Pieces, y: &Pieces| -> Complex<f64> {
        let each = x.values.iter().zip(&y.values).map(|(a, b)| a * b.conj());
        each.map(|v| Complex::new(f64::from(v.re), f64::from(v.im))).sum()
    };
    let powers: Vec<f64> = pieces.iter().map(|own| product(own, own).re).collect();
    let mut matrix = vec![vec![Complex::new(1.0, 0.0); n]; n];
    for a in 0..n {
        for b in 0..a {
            let c = product(&pieces[a], &pieces[b]) / (powers[a] * powers[b]).sqrt().max(1e-300);
            (matrix[a][b], matrix[b][a]) = (c, c.conj());
        }
    }
    // Begin with the one that has most in common with the others; some dozens of turns of the power method.
    let strength = |row: &Vec<Complex<f64>>| row.iter().map(Complex::norm_sqr).sum::<f64>();
    let first =
        (0..n).fold(0, |a, b| if strength(&matrix[b]) > strength(&matrix[a]) { b } else { a });
    let mut vector: Vec<Complex<f64>> = matrix.iter().map(|row| row[first]).collect();
    let mut value = 0.0;
    for _ in 0..60 {
        let next: Vec<Complex<f64>> =
            matrix.iter().map(|row| row.iter().zip(&vector).map(|(m, v)| m * v).sum()).collect();
        let length = next.iter().map(Complex::norm_sqr).sum::<f64>().sqrt().max(1e-300);
        let before = vector.iter().map(Complex::norm_sqr).sum::<f64>().sqrt().max(1e-300);
        value = length / before;
        vector = next.into_iter().map(|v| v / length).collect();
    }
    vector.iter().map(|v| (value * v.norm_sqr()).min(1.0)).collect()
}

fn period(period_s: f64) -> String {
    format!("with a period of {}", spoken::time(period_s))
}
