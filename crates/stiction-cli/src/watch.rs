//! `stiction watch`: starts the collector of live data, which is part of the Python package.
//!
//! The collector encrypts with OpenSSL. Everything that judges is compiled from the same sources as this program.

use anyhow::{Context, Result, bail};
use clap::Parser;
use std::ffi::OsString;
use std::process::{Command, ExitCode, Stdio};

/// Collect a plant's values from an OPC UA server, read-only, and judge the loops hour by hour.
///
/// The command prints events as lines of JSON on standard output, and its log on standard error. The collector needs
/// Python with the package stiction[live]. "python -m stiction.live watch --help" lists all options.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction watch --make-certificate -C north
  stiction watch opc.tcp://server:4840 -C north --history 7d
  stiction watch --status -C north

STICTION_PYTHON names the Python to use. Passwords come from the environment only, such as STICTION_OPCUA_PASSWORD.")]
pub struct Args {
    /// The server, the folder of the plant, and options
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "ARGUMENT")]
    arguments: Vec<OsString>,
}

pub fn run(args: Args) -> Result<ExitCode> {
    let mut command = collector("watch")?;
    command.args(args.arguments);
    // Signals and the exit code are then those of the collector.
    #[cfg(unix)]
    return Err(std::os::unix::process::CommandExt::exec(&mut command)).context("the collector");
    #[cfg(not(unix))]
    ended(&mut command)
}

/// Whether a source of data is an address, such as of a server or a database, and no path.
pub fn is_address(source: &str) -> bool {
    source.contains("://")
}

/// An address without its password and its query, because a query may contain a password.
pub fn without_secrets(address: &str) -> String {
    let plain = address.split('?').next().unwrap_or(address);
    match (plain.split_once("://"), plain.rsplit_once('@')) {
        (Some((scheme, _)), Some((_, host))) => format!("{scheme}://{host}"),
        _ => plain.to_owned(),
    }
}

/// Runs a task of the collector to its end, and returns its exit code.
pub fn ended(command: &mut Command) -> Result<ExitCode> {
    let status = command.status().context("the collector")?;
    Ok(ExitCode::from(status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(2)))
}

/// A task of the collector, with the first Python that has it.
pub fn collector(task: &str) -> Result<Command> {
    /// Finds the package without an import.
    const HAS_IT: &str =
        "import importlib.util as u, sys; sys.exit(u.find_spec('stiction') is None)";
    let named = std::env::var_os("STICTION_PYTHON");
    let known = match &named {
        Some(named) => vec![named.clone()],
        None => ["python3", "python"].map(OsString::from).into(),
    };
    for python in known {
        let mut asked = Command::new(&python);
        let asked = asked.args(["-c", HAS_IT]).stdin(Stdio::null()).stdout(Stdio::null());
        if asked.stderr(Stdio::null()).status().is_ok_and(|status| status.success()) {
            let mut command = Command::new(python);
            command.args(["-m", "stiction.live", task]);
            return Ok(command);
        }
    }
    match named {
        Some(python) => bail!(
            "STICTION_PYTHON is {}, which does not run, or lacks the package; install the package with: pip install \"stiction[live]\"",
            python.display()
        ),
        None => bail!(
            "live data need Python with the package stiction; install the package with: pip install \"stiction[live]\", or name its Python in \
             STICTION_PYTHON"
        ),
    }
}
