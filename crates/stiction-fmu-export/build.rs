//! Settles which libraries FMUs will hold: of the platform that this crate is built for, and of those that the variable
//! `STICTION_FMU_TARGETS` lists, such as `x86_64-pc-windows-gnu`.
//!
//! What ships, built with the profile `dist`, has them built in. Other builds are to be quick, and compile them at the first
//! export.

#[path = "src/compile.rs"]
mod compile;

use compile::{Compiler, answer};
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
    if ships {
        for source in [
            "crates/stiction-model/src",
            "crates/stiction-model/Cargo.toml",
            "crates/stiction-fmu/src",
            "crates/stiction-fmu/Cargo.toml",
            "Cargo.toml",
            "Cargo.lock",
        ] {
            println!("cargo::rerun-if-changed={}", root.join(source).display());
        }
    } else {
        println!("cargo::rerun-if-changed=build.rs");
        println!("cargo::rerun-if-changed=src/compile.rs");
        println!("cargo::rustc-env=STICTION_FMU_OWN={own}");
        println!("cargo::rustc-env=STICTION_FMU_FLAGS={}", compiler.flags);
        println!("cargo::rustc-env=STICTION_FMU_ROOT={}", root.display());
        println!("cargo::rustc-env=STICTION_FMU_FOLDER={}", folder.display());
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
