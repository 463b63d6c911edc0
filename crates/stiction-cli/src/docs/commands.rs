//! The page of all commands, made from their help.

use clap::{Arg, Command};
use std::fmt::Write as _;
use stiction_docs::markdown::literal;
use stiction_docs::{Page, contents};

/// The page.
pub fn page(mut command: Command) -> Page {
    // Usage lines include the name of the program.
    command.build();
    let mut text = "# Commands\n\n".to_owned();
    text += &description(&command);
    let all: Vec<&Command> =
        command.get_subcommands().filter(|each| each.get_name() != "help").collect();
    text += "| command | purpose |\n|---|---|\n";
    for each in &all {
        let about = each.get_about().map_or(String::new(), |about| literal(&about.to_string()));
        let name = each.get_name();
        let _ = writeln!(text, "| [`{name}`](#stiction-{name}) | {about} |");
    }
    for each in all {
        let _ = writeln!(text, "\n## stiction {}\n", each.get_name());
        text += &description(each);
        let usage = each.clone().render_usage().to_string();
        let usage = usage.trim_start_matches("Usage: ").trim();
        let _ = writeln!(text, "```text\n{usage}\n```\n");
        text += &options(each);
        text += &examples(each);
    }
    Page::new(contents::COMMANDS, "Commands", text)
}

/// The description of a command, as paragraphs.
fn description(command: &Command) -> String {
    let about = command.get_long_about().or(command.get_about());
    let paragraphs = about.map(ToString::to_string).unwrap_or_default();
    paragraphs.split("\n\n").map(|paragraph| literal(paragraph) + "\n\n").collect()
}

/// Arguments and options, one row each.
fn options(command: &Command) -> String {
    let mut text = "| option | meaning |\n|---|---|\n".to_owned();
    let shown =
        |arg: &&Arg| !arg.is_hide_set() && !matches!(arg.get_id().as_str(), "help" | "version");
    let arguments: Vec<&Arg> = command.get_arguments().filter(shown).collect();
    // Positional arguments come first.
    let (first, then): (Vec<&Arg>, Vec<&Arg>) =
        arguments.into_iter().partition(|arg| arg.is_positional());
    if first.is_empty() && then.is_empty() {
        return String::new();
    }
    for arg in first.into_iter().chain(then) {
        let short = arg.get_short().map_or(String::new(), |short| format!("-{short}, "));
        let help = arg.get_long_help().or(arg.get_help()).map(ToString::to_string);
        let mut about = literal(&help.unwrap_or_default());
        let values: Vec<String> = arg
            .get_possible_values()
            .iter()
            .filter(|_| arg.get_action().takes_values())
            .map(|value| format!("`{}`", value.get_name()))
            .collect();
        if !values.is_empty() {
            let _ = write!(about, ". One of {}", values.join(", "));
        }
        let defaults: Vec<String> = arg
            .get_default_values()
            .iter()
            .filter(|_| arg.get_action().takes_values())
            .map(|value| format!("`{}`", value.to_string_lossy()))
            .collect();
        if !defaults.is_empty() {
            let _ = write!(about, ". By default {}", defaults.join(", "));
        }
        let name = arg.to_string().replace('|', "\\|");
        let _ = writeln!(text, "| `{short}{name}` | {about} |");
    }
    text + "\n"
}

/// The examples below its help, as commands to copy.
fn examples(command: &Command) -> String {
    let below = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    let Some((_, lines)) = below.split_once(":\n") else { return String::new() };
    let lines: Vec<&str> = lines.lines().map(str::trim).collect();
    format!("```sh\n{}\n```\n", lines.join("\n"))
}
