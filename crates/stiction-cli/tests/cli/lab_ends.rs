//! The lab is ended by Ctrl-C, whatever it is at.
#![cfg(unix)]

use crate::{folder, run};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Ends a process as Ctrl-C does.
fn interrupt(child: &Child) {
    let done = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(done.success());
}

#[test]
fn ctrl_c_ends_a_lab_that_scans_and_leaves_the_store_whole() {
    let folder = folder("lab-ends");
    run(&folder, &["plant", "demo", "--loops", "30", "--days", "4", "-o", "p"]).quiet_success();
    let mut child = Command::new(env!("CARGO_BIN_EXE_stiction"))
        .args(["lab", "--no-open", "--plant", "p"])
        .current_dir(&folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    let (at, token) = line
        .trim()
        .strip_prefix("http://")
        .and_then(|rest| rest.split_once("/#token="))
        .expect("the first line is the address");
    let ask = |call: &str| {
        let mut stream = TcpStream::connect(at).unwrap();
        write!(
            stream,
            "POST /api/{call} HTTP/1.1\r\nHost: {at}\r\nAuthorization: Bearer {token}\r\nConnection: close\r\n\
             Content-Length: 2\r\n\r\n{{}}"
        )
        .unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
        answer
    };
    ask("plant/scan");
    let end = Instant::now() + Duration::from_secs(60);
    // In the middle of judging, as far as the machine lets one be.
    while ask("plant/status").contains("\"looked\":0") {
        assert!(Instant::now() < end);
        std::thread::sleep(Duration::from_millis(20));
    }
    std::thread::sleep(Duration::from_millis(300));
    // Somebody is at the page, too.
    let _idle = TcpStream::connect(at).unwrap();
    interrupt(&child);
    let began = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        assert!(began.elapsed() < Duration::from_secs(2), "Ctrl-C does not end it");
        std::thread::sleep(Duration::from_millis(10));
    };
    assert!(status.success(), "{status}");
    // What it left is judged by the next scan, and then nothing is new.
    let scan = ["plant", "-C", "p", "scan", "--json"];
    run(&folder, &scan).json();
    assert_eq!(run(&folder, &scan).json()["windows"], 0);
    let status = run(&folder, &["plant", "-C", "p", "status", "--json"]).json();
    assert_eq!((&status["loops"], &status["days"]), (&30.into(), &4.into()));
}
