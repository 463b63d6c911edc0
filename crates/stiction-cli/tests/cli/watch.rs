//! `stiction watch`: arguments, streams and the exit code are those of the collector, which a script stands for here.

use crate::{command, folder, run, write};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

/// A Python that has the package if `has_it` is 0, and prints its arguments.
fn python(folder: &Path, has_it: u8) {
    let script = format!(
        "#!/bin/sh\n[ \"$1\" = -c ] && exit {has_it}\necho \"$@\"\necho told >&2\nexit 7\n"
    );
    write(folder, "python", script);
    let executable = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(folder.join("python"), executable).unwrap();
}

fn with_python(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let own = folder.join("python");
    let output = command(folder).env("STICTION_PYTHON", own).args(arguments).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn arguments_streams_and_the_exit_code_are_the_collectors() {
    let folder = folder("watch");
    python(&folder, 0);
    let asked = ["watch", "opc.tcp://host:4840", "-C", "north", "--history", "7d"];
    let (code, out, err) = with_python(&folder, &asked);
    let expected = "-m stiction.live watch opc.tcp://host:4840 -C north --history 7d\n";
    assert_eq!((code, &*out, &*err), (Some(7), expected, "told\n"));
    let init = ["plant", "-C", "north", "init", "opc.tcp://host:4840", "--", "--security", "none"];
    let (code, out, _) = with_python(&folder, &init);
    let expected = "-m stiction.live init -C north --security none opc.tcp://host:4840\n";
    assert_eq!((code, &*out), (Some(7), expected));
    // A scan ends if nothing could be fetched.
    let (code, out, _) =
        with_python(&folder, &["plant", "-C", "north", "scan", "postgres://host/p"]);
    assert_eq!((code, &*out), (Some(7), "-m stiction.live fetch -C north postgres://host/p\n"));
}

#[test]
fn a_missing_package_is_named_with_the_remedy() {
    let folder = folder("watch-none");
    python(&folder, 1);
    let (code, _, err) = with_python(&folder, &["watch", "--status"]);
    assert_eq!(code, Some(2));
    assert!(err.contains("pip install \"stiction[live]\""), "{err}");
    let help = run(&folder, &["watch", "--help"]).quiet_success();
    assert!(help.contains("stiction watch opc.tcp://server:4840"), "{help}");
}

#[test]
fn a_recording_is_read_from_an_address() {
    let folder = folder("watch-address");
    let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples/FIC101-sticky.csv");
    // The stand-in writes the sample to the file that it is asked for, after a few checks.
    let script = format!(
        "#!/bin/sh\n[ \"$1\" = -c ] && exit 0\n\
         [ \"$2 $3 $4 $5\" = 'stiction.live fetch postgres://host/p?table=t --output' ] || exit 3\n\
         echo \"$6\" > asked\ncp {} \"$6\"\n",
        sample.display()
    );
    write(&folder, "python", script);
    let executable = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(folder.join("python"), executable).unwrap();
    let asked = ["diagnose", "postgres://host/p?table=t", "--brief"];
    let (code, out, err) = with_python(&folder, &asked);
    assert_eq!((code, &*err), (Some(0), ""), "{out}");
    assert!(out.contains("sticks"), "{out}");
    let left = std::fs::read_to_string(folder.join("asked")).unwrap();
    assert!(!Path::new(left.trim()).exists(), "{left}");

    // Addresses are read side by side.
    let script = format!(
        "#!/bin/sh\n[ \"$1\" = -c ] && exit 0\n\
         case $4 in *one) of=FIC101-sticky ;; *) of=FIC103-aggressive ;; esac\n\
         cp {}/$of.csv \"$6\"\nsleep 0.2\n",
        sample.parent().unwrap().display()
    );
    write(&folder, "python", script);
    let both = ["diagnose", "postgres://host/p?table=one", "postgres://host/p?table=two", "--json"];
    let (_, out, err) = with_python(&folder, &both);
    assert_eq!(err, "");
    let found: serde_json::Value = serde_json::from_str(&out).unwrap();
    let class = |k: usize| found["loops"][k]["verdict"]["class"].clone();
    assert_eq!((class(0), class(1)), ("sticks".into(), "does not stick".into()));

    python(&folder, 0);
    let secret = ["diagnose", "postgres://me:secret@host/p?table=t&password=hidden", "--brief"];
    let (code, out, err) = with_python(&folder, &secret);
    assert_eq!(code, Some(2), "{err}");
    assert!(err.contains("postgres://host/p: the table was not read"), "{err}");
    assert!(!format!("{out}{err}").contains("secret") && !err.contains("hidden"), "{err}");
    python(&folder, 1);
    let (code, _, err) = with_python(&folder, &asked);
    assert_eq!(code, Some(2), "{err}");
    assert!(err.contains("pip install \"stiction[live]\""), "{err}");
}
