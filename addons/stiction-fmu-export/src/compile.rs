//! Compiles the library of every FMU from the sources in `addons/stiction-fmu`. The build script of a release compiles
//! the libraries, or a light build compiles them at the first export. So this file uses only the standard library.
//!
//! The bytes do not depend on the machine: its paths are replaced.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Compiler, sources and target of a compilation.
pub struct Compiler<'a> {
    /// The program `cargo`.
    pub cargo: &'a str,
    /// The program `rustc`.
    pub rustc: &'a str,
    /// The platform of this build, as Rust names it.
    pub own: &'a str,
    /// Flags of this build, for its own platform, as `CARGO_ENCODED_RUSTFLAGS` has them.
    pub flags: &'a str,
    /// Folder of the workspace.
    pub root: &'a Path,
    /// A target directory of its own, because an outer build holds the lock of the usual one.
    pub folder: &'a Path,
}

impl Compiler<'_> {
    /// Compiles the library for one target unless the library is up to date, and returns its path.
    ///
    /// # Errors
    /// The message of the compiler.
    pub fn library(&self, target: &str, os: &str) -> Result<PathBuf, String> {
        let mut command = Command::new(self.cargo);
        command
            // Only as a library for C: together with one for Rust it would not be optimised as a whole.
            .args(["rustc", "--profile", "dist", "--lib", "--crate-type", "cdylib", "--locked"])
            .args(["--config", "profile.dist.strip=true", "--target", target, "--manifest-path"])
            .arg(self.root.join("addons/stiction-fmu/Cargo.toml"))
            .arg("--target-dir")
            .arg(self.folder)
            .env("CARGO_ENCODED_RUSTFLAGS", self.flags(target)?)
            // The wrapper of clippy in an outer build does not apply to the library.
            .env_remove("RUSTC_WORKSPACE_WRAPPER");
        answer(&mut command)?;
        let name = match os {
            "windows" => "stiction_fmu.dll",
            "macos" => "libstiction_fmu.dylib",
            _ => "libstiction_fmu.so",
        };
        Ok(self.folder.join(target).join("dist").join(name))
    }

    /// Flags of the compiler: the flags of this build if the target is the same, and flags that remove paths.
    fn flags(&self, target: &str) -> Result<String, String> {
        let mut flags: Vec<String> = vec![];
        if target == self.own {
            let outer = self.flags.split('\x1f').filter(|flag| !flag.is_empty());
            flags.extend(outer.map(str::to_owned));
        }
        let home = std::env::var_os("CARGO_HOME")
            .map(PathBuf::from)
            .or_else(|| Some(std::env::home_dir()?.join(".cargo")));
        let sysroot = answer(Command::new(self.rustc).args(["--print", "sysroot"]))?;
        // The last match wins.
        let paths = [
            (Some(self.root.to_owned()), "stiction"),
            (Some(self.folder.to_owned()), "target"),
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
        Ok(flags.join("\x1f"))
    }
}

/// The output of a program.
///
/// # Errors
/// If the program cannot be run or fails. The error is its message.
pub fn answer(command: &mut Command) -> Result<String, String> {
    let program = command.get_program().to_string_lossy().into_owned();
    let output = command.output().map_err(|e| format!("{program} cannot be run: {e}"))?;
    match output.status.success() {
        true => Ok(String::from_utf8_lossy(&output.stdout).into_owned()),
        false => {
            Err(format!("{program} failed: {}", String::from_utf8_lossy(&output.stderr).trim()))
        }
    }
}
