//! Builds the library that goes into every FMU, for the platform that this crate is built for and for
//! those that the variable `STICTION_FMU_TARGETS` lists, such as `x86_64-pc-windows-gnu`.
//!
//! The bytes do not depend on where they are built: paths of the machine are replaced.

use std::path::{Path, PathBuf};
use std::process::Command;

fn var(name: &str) -> String {
    std::env::var(name).unwrap_or_default()
}

fn main() {
    let root = Path::new(&var("CARGO_MANIFEST_DIR")).join("../..");
    let root = root.canonicalize().expect("the workspace is there");
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
    println!("cargo::rerun-if-env-changed=STICTION_FMU_TARGETS");
    let mut targets = vec![var("TARGET")];
    for further in var("STICTION_FMU_TARGETS").split([',', ' ']).filter(|name| !name.is_empty()) {
        if !targets.iter().any(|known| known == further) {
            targets.push(further.to_owned());
        }
    }
    let out = PathBuf::from(var("OUT_DIR"));
    let mut list = String::from("[\n");
    for target in &targets {
        let file = format!("{target}.bin");
        let [arch, os] = platform(target);
        std::fs::copy(library(&root, &out, target, &os), out.join(&file))
            .expect("the library was just built");
        list += &format!(
            "    ({arch:?}, {os:?}, include_bytes!(concat!(env!(\"OUT_DIR\"), \"/{file}\"))),\n"
        );
    }
    std::fs::write(out.join("libraries.rs"), list + "]\n").expect("the directory is ours");
}

/// Builds the library for one target; says where it is.
fn library(root: &Path, out: &Path, target: &str, os: &str) -> PathBuf {
    // A target directory of its own, because the outer build holds the lock of the usual one; beside the build
    // directories of the profile, so that checks, tests and builds have it in common.
    let folder = out.ancestors().nth(3).unwrap_or(out).join("fmu-library");
    let built = Command::new(var("CARGO"))
        // As nothing but a library for C: beside one for Rust it would not be optimised as a whole.
        .args(["rustc", "--profile", "dist", "--lib", "--crate-type", "cdylib", "--locked"])
        .args(["--config", "profile.dist.strip=true"])
        .args(["--target", target])
        .arg("--manifest-path")
        .arg(root.join("crates/stiction-fmu/Cargo.toml"))
        .arg("--target-dir")
        .arg(&folder)
        .env("CARGO_ENCODED_RUSTFLAGS", flags(root, &folder, target))
        // What clippy wraps the outer build in has no part in the library.
        .env_remove("RUSTC_WORKSPACE_WRAPPER")
        .status();
    assert!(
        built.is_ok_and(|status| status.success()),
        "the library of the FMUs could not be built for {target}"
    );
    let name = match os {
        "windows" => "stiction_fmu.dll",
        "macos" => "libstiction_fmu.dylib",
        _ => "libstiction_fmu.so",
    };
    folder.join(target).join("dist").join(name)
}

/// Flags of the compiler: those of this build if the target is the same, and what keeps paths out.
fn flags(root: &Path, folder: &Path, target: &str) -> String {
    let mut flags: Vec<String> = vec![];
    if target == var("TARGET") {
        let outer = var("CARGO_ENCODED_RUSTFLAGS");
        flags.extend(outer.split('\x1f').filter(|flag| !flag.is_empty()).map(str::to_owned));
    }
    let home = std::env::var_os("CARGO_HOME")
        .map(PathBuf::from)
        .or_else(|| Some(std::env::home_dir()?.join(".cargo")));
    let sysroot = asked(&["--print", "sysroot"]);
    // The last that fits is taken.
    let paths = [
        (Some(root.to_owned()), "stiction"),
        (Some(folder.to_owned()), "target"),
        (home, "cargo"),
        (Some(PathBuf::from(sysroot.trim())), "rust"),
    ];
    for (path, name) in paths {
        if let Some(path) = path {
            flags.push(format!("--remap-path-prefix={}={name}", path.display()));
        }
    }
    if target.ends_with("windows-gnu") {
        flags.push("-Clink-arg=-Wl,--no-insert-timestamp".to_owned());
    }
    flags.join("\x1f")
}

/// Processor and system of a target, as Rust names them.
fn platform(target: &str) -> [String; 2] {
    let all = asked(&["--print", "cfg", "--target", target]);
    ["target_arch", "target_os"].map(|key| {
        let value = all.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('='));
        value.unwrap_or_else(|| panic!("the compiler does not know {target}")).replace('"', "")
    })
}

/// What the compiler answers.
fn asked(arguments: &[&str]) -> String {
    let output = Command::new(var("RUSTC")).args(arguments).output().expect("the compiler runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}
