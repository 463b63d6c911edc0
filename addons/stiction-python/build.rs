//! Copies the sample recordings for maturin into the wheel, because the repository keeps only one copy.

use std::path::Path;
use std::{env, fs};

fn main() {
    let folder = |name| env::var(name).expect("cargo says where");
    let samples = Path::new(&folder("CARGO_MANIFEST_DIR")).join("../../samples");
    println!("cargo::rerun-if-changed={}", samples.display());
    for entry in fs::read_dir(&samples).expect("the samples are there") {
        let file = entry.expect("a folder can be listed").path();
        if file.extension().is_some_and(|extension| extension == "csv") {
            let name = file.file_name().expect("a file has a name");
            fs::copy(&file, Path::new(&folder("OUT_DIR")).join(name)).expect("it can be copied");
        }
    }
}
