//! The frame of every page: the list of contents, the search, the links to neighbouring pages.

use crate::contents::{self, Section};
use crate::markdown::Rendered;
use crate::{relative, search};
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// Style and script of all pages, and their places.
pub(crate) const STYLE: &str = include_str!("site.css");
pub(crate) const STYLE_PATH: &str = "assets/site.css";
pub(crate) const SCRIPT: &str = include_str!("site.js");
pub(crate) const SCRIPT_PATH: &str = "assets/site.js";

/// The first page.
const START: &str = "index.html";
/// Smallest number of chapters for which a page has a list of chapters.
const CHAPTERS: usize = 3;

/// A page as an HTML document.
pub(crate) fn page(tool: &str, sections: &[Section], page: &Rendered) -> String {
    let to = |path: &str| relative(&page.path, path);
    let chapters: Vec<_> = page.parts.iter().filter(|part| part.level == 2).collect();
    let document = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="generator" content="stiction";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (page.title) " | stiction" }
                link rel="stylesheet" href=(to(STYLE_PATH));
                script src=(to(SCRIPT_PATH)) data-index=(to(search::PATH)) data-top=(to("")) defer {}
            }
            body {
                a.skip href="#content" { "Skip to the content" }
                header.top {
                    a.name href=(to(START)) { "stiction" }
                    a.to-contents href="#contents" { "Contents" }
                    div.search role="search" {
                        input #search type="search" placeholder="Search" autocomplete="off"
                            aria-label="Search all pages" aria-controls="found" disabled;
                        ul #found hidden {}
                    }
                }
                div.frame {
                    (list(sections, page))
                    main #content.alone[chapters.len() < CHAPTERS] tabindex="-1" {
                        (PreEscaped(&page.html))
                        @if page.path == START { (overview(sections)) }
                        (neighbours(page))
                    }
                    @if chapters.len() >= CHAPTERS {
                        nav.chapters aria-label="On this page" {
                            p { "On this page" }
                            ul {
                                @for part in chapters {
                                    li { a href={ "#" (part.anchor) } { (part.heading) } }
                                }
                            }
                        }
                    }
                }
                footer { (tool) }
            }
        }
    };
    document.into_string()
}

/// The list of contents.
fn list(sections: &[Section], page: &Rendered) -> Markup {
    html! {
        nav.contents #contents aria-label="Contents" {
            @for section in sections {
                p { (section.title) }
                ul {
                    @for each in section.pages {
                        @let here = each.path == page.path;
                        li {
                            a.above[each.path == page.listed] href=(relative(&page.path, each.path))
                                aria-current=[here.then_some("page")] { (each.title) }
                        }
                    }
                }
            }
        }
    }
}

/// All sections with their pages, for the first page.
fn overview(sections: &[Section]) -> Markup {
    html! {
        div.sections {
            @for section in sections {
                section {
                    h2 { (section.title) }
                    p { (section.about) }
                    ul {
                        @for each in section.pages.iter().filter(|each| each.path != START) {
                            li { a href=(each.path) { (each.title) } }
                        }
                    }
                }
            }
        }
    }
}

/// The pages before and after, in the order of the contents.
fn neighbours(page: &Rendered) -> Markup {
    let all: Vec<_> = contents::pages().collect();
    let place = all.iter().position(|each| each.path == page.listed);
    let before = match place {
        // A page that belongs to another leads back to it.
        Some(place) if page.listed != page.path => Some(all[place]),
        Some(place) => place.checked_sub(1).map(|place| all[place]),
        None => None,
    };
    let after = match place {
        Some(place) if page.listed == page.path => all.get(place + 1),
        _ => None,
    };
    html! {
        nav.neighbours aria-label="Pages before and after" {
            @if let Some(each) = before {
                a rel="prev" href=(relative(&page.path, each.path)) { "← " (each.title) }
            }
            @if let Some(each) = after {
                a.next rel="next" href=(relative(&page.path, each.path)) { (each.title) " →" }
            }
        }
    }
}
