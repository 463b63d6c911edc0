//! A detector that is a program: it reads recordings as lines of JSON and writes an answer for each.

use super::entrants::PASSPHRASE;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStderr, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, channel, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use stiction::score::bench::exchange::{ParsedLine, parsed_line};
use stiction::scoreboard::Answer;

/// Number of consecutive starts without an answer, after which a program is not started again.
const STARTS: usize = 10;
/// Number of bytes of a line that are read; the rest of a longer one is skipped.
const LINE: u64 = 1 << 20;
/// Number of bytes of standard error that are kept.
const ERRORS: usize = 4096;
/// Time for a program to end once its input has ended.
const END: Duration = Duration::from_secs(2);

/// How a program is run.
#[derive(Debug, Clone)]
pub struct How {
    /// The command, for the shell.
    pub command: String,
    /// Time for an answer.
    pub limit: Duration,
    /// Additional time for the first answer after a start.
    pub startup: Duration,
}

/// A program that is started, asked, and started again after a crash or timeout.
pub struct Program<'a> {
    how: &'a How,
    running: Option<Running>,
    /// Starts since the last answer.
    vain: usize,
}

/// A running program. Threads write to it and read from it, so that neither process can block.
struct Running {
    child: Child,
    input: Sender<Arc<str>>,
    lines: Receiver<String>,
    errors: Arc<Mutex<Vec<u8>>>,
    answered: bool,
}

impl<'a> Program<'a> {
    pub fn new(how: &'a How) -> Self {
        Self { how, running: None, vain: 0 }
    }

    /// The answer about the recording `id` in this line.
    pub fn ask(&mut self, id: &str, line: String) -> Answer {
        if self.vain >= STARTS {
            return Answer::none(
                format!("not asked, after {STARTS} starts without an answer"),
                0.0,
            );
        }
        let running = match self.running.take() {
            Some(running) => Ok(running),
            None => {
                self.vain += 1;
                Running::start(&self.how.command)
            }
        };
        let mut running = match running {
            Ok(running) => running,
            Err(e) => return Answer::none(format!("the program does not start: {e}"), 0.0),
        };
        let limit = match running.answered {
            true => self.how.limit,
            false => self.how.limit + self.how.startup,
        };
        let asked = Instant::now();
        // A program that has ended is noticed below.
        let _ = running.input.send((line + "\n").into());
        let mut other = None;
        loop {
            let left = limit.saturating_sub(asked.elapsed());
            let time_s = || asked.elapsed().as_secs_f64();
            match running.lines.recv_timeout(left) {
                Ok(text) => match parsed_line(&text, id) {
                    ParsedLine::Answer(answer) => {
                        let time_s = time_s();
                        running.answered = true;
                        self.running = Some(running);
                        self.vain = 0;
                        return Answer { time_s, ..answer };
                    }
                    ParsedLine::Other => other = Some(text),
                },
                Err(RecvTimeoutError::Timeout) => {
                    let time_s = time_s();
                    running.kill();
                    let said = other.map_or(String::new(), |text| {
                        format!("; its last line is {:?}", shortened(text.trim()))
                    });
                    return Answer::none(
                        format!("no answer within {} s{said}", limit.as_secs_f64()),
                        time_s,
                    );
                }
                Err(RecvTimeoutError::Disconnected) => {
                    let time_s = time_s();
                    return Answer::none(running.ended(), time_s);
                }
            }
        }
    }
}

impl Drop for Program<'_> {
    fn drop(&mut self) {
        let Some(mut running) = self.running.take() else { return };
        // The end of its input ends a program.
        running.input = channel().0;
        let since = Instant::now();
        while since.elapsed() < END && matches!(running.child.try_wait(), Ok(None)) {
            std::thread::sleep(Duration::from_millis(5));
        }
        running.kill();
    }
}

impl Running {
    fn start(command: &str) -> std::io::Result<Self> {
        let mut child = shell(command)
            // A detector of others must not learn the hidden seeds.
            .env_remove(PASSPHRASE)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()?;
        let (input, asked) = channel::<Arc<str>>();
        let (sender, lines) = sync_channel(64);
        let errors = Arc::new(Mutex::new(vec![]));
        if let Some(mut to) = child.stdin.take() {
            std::thread::spawn(move || {
                for line in asked {
                    if to.write_all(line.as_bytes()).and_then(|()| to.flush()).is_err() {
                        break;
                    }
                }
            });
        }
        if let Some(from) = child.stdout.take() {
            std::thread::spawn(move || listen(from, &sender));
        }
        if let Some(from) = child.stderr.take() {
            let errors = Arc::clone(&errors);
            std::thread::spawn(move || keep(from, &errors));
        }
        Ok(Self { child, input, lines, errors, answered: false })
    }

    /// Ends the program and its child processes.
    fn kill(&mut self) -> Option<ExitStatus> {
        #[cfg(unix)]
        {
            let all = format!("kill -KILL -{}", self.child.id());
            let _ = Command::new("sh").args(["-c", &all]).stderr(Stdio::null()).status();
        }
        let _ = self.child.kill();
        self.child.wait().ok()
    }

    /// Why it ended, in words.
    fn ended(mut self) -> String {
        // Its output has ended, and it may take a moment to end itself.
        let since = Instant::now();
        let mut status = None;
        while status.is_none() && since.elapsed() < END {
            status = self.child.try_wait().ok().flatten();
            std::thread::sleep(Duration::from_millis(2));
        }
        let ended = match status {
            Some(status) => match status.code() {
                Some(code) => format!("the program ended with exit code {code}"),
                None => format!("the program ended ({status})"),
            },
            None => "the program closed its standard output".to_owned(),
        };
        self.kill();
        let errors = self.errors.lock().unwrap_or_else(PoisonError::into_inner);
        let text = String::from_utf8_lossy(&errors);
        match text.lines().rev().find(|line| !line.trim().is_empty()) {
            Some(last) => format!("{ended}: {}", shortened(last.trim())),
            None => ended,
        }
    }
}

fn shortened(text: &str) -> String {
    match text.char_indices().nth(160) {
        Some((at, _)) => format!("{}...", &text[..at]),
        None => text.to_owned(),
    }
}

/// The command in a shell, and in a separate process group, so that the whole group can be ended.
fn shell(command: &str) -> Command {
    #[cfg(unix)]
    {
        use std::os::unix::process::CommandExt;
        let mut shell = Command::new("sh");
        shell.args(["-c", command]).process_group(0);
        shell
    }
    #[cfg(not(unix))]
    {
        let mut shell = Command::new("cmd");
        shell.args(["/C", command]);
        shell
    }
}

/// Passes lines on until no caller waits for them. Of a long line, only the beginning.
fn listen(from: ChildStdout, to: &SyncSender<String>) {
    let mut from = BufReader::new(from);
    let (mut line, mut skips) = (vec![], false);
    loop {
        line.clear();
        let read = (&mut from).take(LINE).read_until(b'\n', &mut line);
        if !read.is_ok_and(|n| n > 0) {
            return;
        }
        let skipped = skips;
        skips = line.last() != Some(&b'\n');
        if !skipped && to.send(String::from_utf8_lossy(&line).into_owned()).is_err() {
            return;
        }
    }
}

/// Keeps the end of standard error.
fn keep(mut from: ChildStderr, errors: &Mutex<Vec<u8>>) {
    let mut part = [0; 1024];
    while let Ok(n @ 1..) = from.read(&mut part) {
        let mut kept = errors.lock().unwrap_or_else(PoisonError::into_inner);
        kept.extend(&part[..n]);
        let beyond = kept.len().saturating_sub(ERRORS);
        kept.drain(..beyond);
    }
}
