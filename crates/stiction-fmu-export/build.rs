//! Builds the library that goes into every FMU, for the platform that this crate is built for.

use std::path::{Path, PathBuf};
use std::process::Command;

fn main() {
    let var = |name: &str| std::env::var(name).unwrap_or_default();
    let crates = Path::new(&var("CARGO_MANIFEST_DIR")).join("..");
    for source in
        ["stiction/src", "stiction/model", "stiction/Cargo.toml", "stiction-fmu", "../Cargo.lock"]
    {
        println!("cargo::rerun-if-changed={}", crates.join(source).display());
    }
    let out = PathBuf::from(var("OUT_DIR"));
    // A target directory of its own: the outer build holds the lock of the usual one.
    let folder = out.join("library");
    let built = Command::new(var("CARGO"))
        .args(["build", "--release", "--lib", "--locked", "--config", "profile.release.strip=true"])
        .args(["--target", &var("TARGET")])
        .arg("--manifest-path")
        .arg(crates.join("stiction-fmu/Cargo.toml"))
        .arg("--target-dir")
        .arg(&folder)
        // What clippy wraps the outer build in has no part in the library.
        .env_remove("RUSTC_WORKSPACE_WRAPPER")
        .status();
    assert!(
        built.is_ok_and(|status| status.success()),
        "the library of the FMUs could not be built"
    );
    let name = match var("CARGO_CFG_TARGET_OS").as_str() {
        "windows" => "stiction_fmu.dll",
        "macos" => "libstiction_fmu.dylib",
        _ => "libstiction_fmu.so",
    };
    let library = folder.join(var("TARGET")).join("release").join(name);
    std::fs::copy(library, out.join("library.bin")).expect("the library was just built");
    println!("cargo::rustc-env=STICTION_FMU_ARCH={}", var("CARGO_CFG_TARGET_ARCH"));
    println!("cargo::rustc-env=STICTION_FMU_OS={}", var("CARGO_CFG_TARGET_OS"));
}
