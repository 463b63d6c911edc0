//! `stiction docs`: the site is whole, tells the truth, and every command that it shows runs.

use crate::{command, folder, read, refuses, run, write};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// The site, written once for all tests that read it.
fn site() -> &'static Path {
    static SITE: OnceLock<PathBuf> = OnceLock::new();
    SITE.get_or_init(|| {
        let folder = folder("docs");
        let said = run(&folder, &["docs", "-o", "site"]).quiet_success();
        assert_eq!(said.trim(), Path::new("site").join("index.html").to_str().expect("UTF-8"));
        folder.join("site")
    })
}

/// Names and bytes of all files below a folder, with `/` between folders.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(each) = open.pop() {
        for entry in std::fs::read_dir(&each).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                open.push(path);
            } else {
                let name = path.strip_prefix(folder).expect("below it").to_string_lossy();
                found.insert(name.replace('\\', "/"), std::fs::read(&path).expect("a file"));
            }
        }
    }
    found
}

/// The values of an attribute in the tags of a page, outside of its scripts.
fn values<'p>(page: &'p str, attribute: &str) -> Vec<&'p str> {
    let mut found = vec![];
    let mut rest = page;
    let start = format!(" {attribute}=\"");
    while let Some(at) = rest.find('<') {
        let tag = &rest[at..];
        let end = tag.find('>').map_or(tag.len(), |end| end + 1);
        let (tag, after) = tag.split_at(end);
        found.extend(tag.split_once(&start).and_then(|(_, v)| v.split_once('"')).map(|(v, _)| v));
        let script = tag.starts_with("<script");
        rest = if script { after.split_once("</script>").map_or("", |(_, r)| r) } else { after };
    }
    found
}

/// The text of HTML without marks.
fn plain(html: &str) -> String {
    let mut text = String::new();
    let mut inside = false;
    for c in html.chars() {
        match c {
            '<' => inside = true,
            '>' => inside = false,
            c if !inside => text.push(c),
            _ => {}
        }
    }
    text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&")
}

/// The blocks of commands on a page.
fn commands(page: &str) -> Vec<String> {
    let blocks = page.split("<code class=\"language-sh\">").skip(1);
    blocks.map(|block| plain(block.split("</code>").next().expect("its end"))).collect()
}

/// Runs lines of a shell in a folder, with our command in reach.
fn shell(folder: &Path, lines: &str) {
    let bin = Path::new(env!("CARGO_BIN_EXE_stiction")).parent().expect("a folder");
    let path = std::env::var_os("PATH").unwrap_or_default();
    let paths = [bin.to_path_buf()].into_iter().chain(std::env::split_paths(&path));
    let path = std::env::join_paths(paths).expect("a path");
    let script = format!("set -e\n{lines}");
    let mut shell = Command::new("sh");
    let done = shell.args(["-c", &script]).current_dir(folder).env("PATH", path).output();
    let done = done.expect("a shell");
    assert!(done.status.success(), "{lines}\n{}", String::from_utf8_lossy(&done.stderr));
}

#[test]
fn nothing_is_broken_and_nothing_comes_from_elsewhere() {
    let files = files(site());
    let text = |name: &str| std::str::from_utf8(&files[name]).expect("UTF-8");
    let pages: Vec<&String> = files.keys().filter(|name| name.ends_with(".html")).collect();
    assert!(pages.len() > 60, "{}", pages.len());
    let anchors: BTreeMap<&String, BTreeSet<&str>> =
        pages.iter().map(|name| (*name, values(text(name), "id").into_iter().collect())).collect();
    for name in &pages {
        let page = text(name);
        let own = page.split("url(").skip(1).all(|rest| rest.starts_with('#'));
        assert!(own && !page.contains("@import"), "{name}");
        let resources = ["src", "data-index"].iter().flat_map(|of| values(page, of));
        let links = values(page, "href");
        for (link, loads) in
            resources.map(|r| (r, true)).chain(links.into_iter().map(|l| (l, false)))
        {
            if link.starts_with("https://") {
                assert!(
                    !loads && !page.contains(&format!("<link rel=\"stylesheet\" href=\"{link}")),
                    "{name}: {link}"
                );
                continue;
            }
            let (file, anchor) = link.split_once('#').map_or((link, None), |(f, a)| (f, Some(a)));
            let mut there: Vec<&str> = name.split('/').collect();
            let own = there.pop().expect("a name");
            for part in file.split('/') {
                match part {
                    "." => {}
                    ".." => drop(there.pop().unwrap_or_else(|| panic!("{name}: {link}"))),
                    "" => there.push(own),
                    part => there.push(part),
                }
            }
            let there = there.join("/");
            assert!(files.contains_key(&there), "{name}: {link}");
            if let Some(anchor) = anchor {
                assert!(anchors[&there].contains(anchor), "{name}: {link}");
            }
        }
        let images = page.matches("<img ").count();
        let named = values(page, "alt").into_iter().filter(|alt| !alt.is_empty()).count();
        assert_eq!(images, named, "{name}: an image without words");
    }
    for name in files.keys().filter(|name| name.ends_with(".js") || name.ends_with(".css")) {
        let known = !name.ends_with("search.js") && text(name).contains("://");
        assert!(!known, "{name} asks the network");
    }
}

#[test]
fn the_search_finds_what_the_pages_say() {
    let script = read(site(), "assets/search.js");
    let rows =
        script.trim().strip_prefix("window.searchIndex = ").and_then(|s| s.strip_suffix(';'));
    let rows: Vec<[String; 4]> = serde_json::from_str(rows.expect("an array")).expect("rows");
    let with = |words: &str| rows.iter().filter(|row| row[3].contains(words)).count();
    assert!(with("dead band") > 5 && with("stiction simulate") > 5);
    for [_, heading, address, text] in &rows {
        assert!(!heading.is_empty(), "{address}: {text}");
        let file = address.split('#').next().expect("a file");
        assert!(site().join(file).is_file(), "{address}");
    }
}

#[test]
fn it_is_written_over_itself_and_over_nothing_else() {
    let folder = folder("docs-again");
    for threads in ["1", "2"] {
        let mut again = command(&folder);
        let again = again.env("RAYON_NUM_THREADS", threads).args(["docs", "-o", "site"]);
        assert!(again.status().expect("it starts").success());
    }
    assert!(files(&folder.join("site")) == files(site()), "the same bytes");
    write(&folder, "mine.txt", "mine");
    refuses(&folder, &["docs", "-o", "."], "name an empty or a new folder with -o");
    assert_eq!(read(&folder, "mine.txt"), "mine");
    write(&folder, "site/mine.txt", "mine");
    run(&folder, &["docs", "-o", "site"]).quiet_success();
    assert_eq!(read(&folder, "site/mine.txt"), "mine");
    refuses(&folder, &["docs", "-o", "mine.txt"], "mine.txt");
}

#[cfg(target_os = "linux")]
#[test]
fn without_a_folder_it_goes_to_the_caches_of_the_user() {
    let folder = folder("docs-cache");
    let mut docs = command(&folder);
    let done = docs.env("XDG_CACHE_HOME", &folder).arg("docs").output().expect("it starts");
    let index = String::from_utf8(done.stdout).expect("UTF-8");
    assert!(Path::new(index.trim()).starts_with(&folder) && Path::new(index.trim()).is_file());
}

/// The commands of a case make the recording that the site has, and from that file comes the verdict that it shows.
#[cfg(unix)]
#[test]
fn cases_are_what_their_files_and_commands_say() {
    let folder = folder("docs-cases");
    let gallery = site().join("gallery");
    let all = files(&gallery);
    let tags: Vec<&str> = all.keys().filter_map(|name| name.strip_suffix(".csv")).collect();
    assert_eq!(tags.len(), 12);
    for tag in tags {
        let page = read(&gallery, &format!("{tag}.html"));
        let lines = commands(&page).concat();
        shell(&folder, &lines);
        let made = [format!("{tag}.csv"), format!("{tag}/loop-0.csv")];
        let made = made.iter().find(|name| folder.join(name).is_file()).expect("a recording");
        assert!(read(&folder, made) == read(&gallery, &format!("{tag}.csv")), "{tag}");

        let kind = lines.split_once("--type ").expect("a type").1.split(' ').next().expect("it");
        let file = format!("{tag}.csv");
        let json = run(&gallery, &["diagnose", &file, "--type", kind, "--json"]).json();
        let found = &json["loops"][0];
        let shown = plain(page.split_once("<dl class=\"facts\">").expect("facts").1);
        let shown = shown.split("What this loop shows").next().expect("facts");
        let grade = found["verdict"]["grade"].as_str().expect("a grade");
        assert!(shown.contains(&format!("Verdict{}", symbol(grade))), "{tag}: {grade}\n{shown}");
        if let Some(s) = found["stiction"]["S"]["value"].as_f64() {
            let told = format!("{s:.1}");
            let told = told.strip_suffix(".0").unwrap_or(&told);
            assert!(shown.contains(&format!("{told} % (")), "{tag}: S {s}\n{shown}");
        }
        let measured = found["verdict"]["basis"] == "valve position";
        if let Some(p) = found["verdict"]["probability"].as_f64().filter(|_| !measured) {
            let told = match 100.0 * p {
                p if p > 99.0 => "more than 99 %".to_owned(),
                p if p < 1.0 => "less than 1 %".to_owned(),
                p => format!("{p:.0} %"),
            };
            assert!(shown.contains(&format!("sticking{told}")), "{tag}: {p}\n{shown}");
        }
    }
}

/// A grade as its badge tells it.
fn symbol(grade: &str) -> String {
    let symbol = match grade {
        "sticks" => "●",
        "does not respond" => "■",
        "probably sticks" => "◐",
        "unclear" => "?",
        "probably fine" => "◌",
        "no stiction visible" => "◎",
        "too little to matter" => "◦",
        "fine" => "○",
        _ => "–",
    };
    format!("{symbol} {grade}")
}

#[cfg(unix)]
#[test]
fn figures_of_the_paper_can_be_simulated_as_the_page_says() {
    let folder = folder("docs-paper");
    let page = read(site(), "paper.html");
    let all = commands(&page);
    assert_eq!(all.len(), page.matches("<h2 ").count());
    all.iter().for_each(|lines| shell(&folder, lines));
    let made = files(&folder);
    let drawn = made.keys().filter(|name| name.ends_with(".svg")).count();
    assert!(drawn >= 13, "{drawn}");
}

#[test]
fn every_command_and_option_is_on_the_page_of_commands() {
    let folder = folder("docs-commands");
    let page = plain(&read(site(), "commands.html"));
    let help = run(&folder, &["-h"]).quiet_success();
    for name in crate::session::commands(&help) {
        assert!(page.contains(&format!("stiction {name} #")), "{name}");
        let help = run(&folder, &[name, "--help"]).quiet_success();
        let flags = help.split_whitespace().filter(|word| {
            word.starts_with("--")
                && word.len() > 4
                && word[2..].chars().all(|c| c.is_ascii_lowercase() || c == '-')
        });
        for flag in flags.filter(|flag| *flag != "--help") {
            assert!(page.contains(flag), "{name} {flag}");
        }
    }
}
