//! Settles which libraries FMUs will hold: of the platform that this crate is built for, and of those that the variable
//! `STICTION_FMU_TARGETS` lists, such as `x86_64-pc-windows-gnu`.
//!
//! What ships, built with the profile `dist`, has them built in. Other builds are to be quick, and compile them at the first
//! export.

#[path = "src/compile.rs"]
mod compile;

use compile::{Compiler, answer};
use std::hash::{DefaultHasher, Hasher};
use std::path::{Path, PathBuf};
use std::process::Command;

fn var(name: &str) -> String {
    std::env::var(name).unwrap_or_default()
}

fn main() {
    let root = Path::new(&var("CARGO_MANIFEST_DIR")).join("../..");
    let root = root.canonicalize().expect("the workspace is there");
    println!("cargo::rerun-if-env-changed=STICTION_FMU_TARGETS");
    let out = PathBuf::from(var("OUT_DIR"));
    // A build script is told its profile by nothing but the folder that it writes to.
    let profile = out.ancestors().nth(3).unwrap_or(&out);
    let folder = profile.join("fmu-library");
    let ships = profile.file_name().is_some_and(|name| name == "dist");
    let (cargo, rustc, own) = (var("CARGO"), var("RUSTC"), var("TARGET"));
    let compiler = Compiler {
        cargo: &cargo,
        rustc: &rustc,
        own: &own,
        flags: &var("CARGO_ENCODED_RUSTFLAGS"),
        root: &root,
        folder: &folder,
    };
    let mut targets = vec![own.clone()];
    for further in var("STICTION_FMU_TARGETS").split([',', ' ']).filter(|name| !name.is_empty()) {
        if !targets.iter().any(|known| known == further) {
            targets.push(further.to_owned());
        }
    }
    let mut platforms = String::from("[\n");
    for target in &targets {
        let [arch, os] = platform(&rustc, target);
        let mut bytes = "None".to_owned();
        if ships {
            let built = compiler.library(target, &os).unwrap_or_else(|why| panic!("{why}"));
            let file = format!("{target}.bin");
            std::fs::copy(built, out.join(&file)).expect("the library was just built");
            bytes = format!("Some(include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{file}\")))");
        }
        platforms += &format!(
            "Platform {{ target: {target:?}, arch: {arch:?}, os: {os:?}, library: {bytes} }},\n"
        );
    }
    std::fs::write(out.join("platforms.rs"), platforms + "]\n").expect("the directory is ours");
    let sources = [
        "crates/stiction-model/src",
        "crates/stiction-model/Cargo.toml",
        "addons/stiction-fmu/src",
        "addons/stiction-fmu/Cargo.toml",
        "Cargo.toml",
        "Cargo.lock",
    ]
    .map(|source| root.join(source));
    for source in &sources {
        println!("cargo::rerun-if-changed={}", source.display());
    }
    if !ships {
        let mut hash = DefaultHasher::new();
        sources.iter().for_each(|source| hashed(source, &mut hash));
        println!("cargo::rerun-if-changed=build.rs");
        println!("cargo::rerun-if-changed=src/compile.rs");
        println!("cargo::rustc-env=STICTION_FMU_OWN={own}");
        println!("cargo::rustc-env=STICTION_FMU_FLAGS={}", compiler.flags);
        println!("cargo::rustc-env=STICTION_FMU_ROOT={}", root.display());
        println!("cargo::rustc-env=STICTION_FMU_FOLDER={}", folder.display());
        println!("cargo::rustc-env=STICTION_FMU_SOURCES={:016x}", hash.finish());
    }
}

/// Adds the contents of a file, or of all files below a folder.
fn hashed(path: &Path, hash: &mut DefaultHasher) {
    if let Ok(entries) = std::fs::read_dir(path) {
        let mut below: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        below.sort();
        below.iter().for_each(|path| hashed(path, hash));
    } else {
        hash.write(&std::fs::read(path).expect("a source can be read"));
    }
}

/// Processor and system of a target, as Rust names them.
fn platform(rustc: &str, target: &str) -> [String; 2] {
    let cfg = answer(Command::new(rustc).args(["--print", "cfg", "--target", target]));
    let all = cfg.unwrap_or_else(|why| panic!("{why}"));
    ["target_arch", "target_os"].map(|key| {
        let value = all.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('='));
        value.unwrap_or_else(|| panic!("the compiler does not know {target}")).replace('"', "")
    })
}
