//! Loops that swing together, on networks whose truth is known.

use stiction_plant::trial::Trial;

#[test]
#[ignore = "looked at by hand"]
fn trial() {
    let of = |name: &str, other: u64| std::env::var(name).map_or(other, |v| v.parse().unwrap());
    let started = std::time::Instant::now();
    let trial = Trial::run(of("SEED", 7), of("N", 12), of("DAYS", 3) as u32, || {}).unwrap();
    println!("{trial:#?} {:?}", started.elapsed());
}
