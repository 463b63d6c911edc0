//! Passes the commit to the command, if it is built in a clone.

use std::path::Path;
use std::process::Command;

fn main() {
    let git = |arguments: &[&str]| {
        let out = Command::new("git").args(arguments).output().ok()?;
        let text = String::from_utf8(out.stdout).ok()?;
        out.status.success().then(|| text.trim().to_owned())
    };
    println!("cargo:rerun-if-changed=build.rs");
    // Only a clone of this project has a commit of its own.
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let commit =
        root.join(".git").exists().then(|| git(&["rev-parse", "--short=10", "HEAD"])).flatten();
    for name in ["HEAD", "logs/HEAD"] {
        if let Some(path) = git(&["rev-parse", "--git-path", name]) {
            println!("cargo:rerun-if-changed={path}");
        }
    }
    let commit = commit.map_or(String::new(), |commit| format!(" (commit {commit})"));
    println!("cargo:rustc-env=STICTION_COMMIT={commit}");
}
