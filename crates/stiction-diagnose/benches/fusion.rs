//! Speed of the frozen model: a thousand trees of sixteen leaves, on rows that take different ways.

use criterion::{Criterion, criterion_group, criterion_main};
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::hint::black_box;
use stiction_diagnose::fusion::{Ensemble, Node};

const FEATURES: u64 = 150;

/// A number from -1 to 1.
fn unit(random: &mut Xoshiro256PlusPlus) -> f32 {
    (random.next_u64() >> 40) as f32 / (1u64 << 23) as f32 - 1.0
}

/// A tree of so many leaves, in preorder, of a shape drawn at random.
fn grow(random: &mut Xoshiro256PlusPlus, leaves: u64, tree: &mut Vec<Node>) {
    if leaves == 1 {
        tree.push(Node::Leaf(unit(random)));
        return;
    }
    tree.push(Node::Split {
        feature: (random.next_u64() % FEATURES) as u16,
        threshold: unit(random),
        missing_right: random.next_u64().is_multiple_of(2),
    });
    let left = 1 + random.next_u64() % (leaves - 1);
    grow(random, left, tree);
    grow(random, leaves - left, tree);
}

fn margins(criterion: &mut Criterion) {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
    let trees: Vec<Vec<Node>> = (0..1000)
        .map(|_| {
            let mut tree = vec![];
            grow(&mut random, 16, &mut tree);
            tree
        })
        .collect();
    let ensemble = Ensemble::new(0.0, &trees).expect("trees are sound");
    let rows: Vec<Vec<f32>> =
        (0..256).map(|_| (0..FEATURES).map(|_| unit(&mut random)).collect()).collect();
    let mut next = 0;
    criterion.bench_function("1,000 trees of 16 leaves", |bencher| {
        bencher.iter(|| {
            next = (next + 1) % rows.len();
            black_box(ensemble.margin(&rows[next]))
        });
    });
}

criterion_group!(benches, margins);
criterion_main!(benches);
