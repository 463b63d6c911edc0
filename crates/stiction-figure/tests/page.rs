//! What the HTML page must have.

use stiction_figure::{Entry, Page, Picture};

const SVG: &str = "<svg xmlns=\"http://www.w3.org/2000/svg\"></svg>";

fn page() -> Page {
    Page::new("Figures of <S> & J", "An introduction with \"quotes\".", "stiction 0.1.0")
        .with(
            Entry::new("Figure 5 <b>", Picture::Inline(SVG.into()), "Valve & ramp")
                .parameter("slip jump J", 3.5, "%")
                .parameter("<i>", "a < b", "m³/h"),
        )
        .with(Entry::new(
            "Figure 4",
            Picture::File("figures/flow chart.svg".into()),
            "Flow \"chart\"",
        ))
}

#[test]
fn everything_is_there_and_escaped() {
    let html = page().html();
    for text in [
        "<title>Figures of &lt;S&gt; &amp; J</title>",
        "<h1>Figures of &lt;S&gt; &amp; J</h1>",
        "An introduction with &quot;quotes&quot;.",
        "<h2>Figure 5 &lt;b&gt;</h2>",
        SVG,
        "<figcaption>Valve &amp; ramp</figcaption>",
        "<th scope=\"row\">slip jump J</th><td>3.5</td><td>%</td>",
        "<th scope=\"row\">&lt;i&gt;</th><td>a &lt; b</td><td>m³/h</td>",
        "<img src=\"./figures/flow%20chart.svg\" alt=\"Flow &quot;chart&quot;\">",
        "<footer>stiction 0.1.0</footer>",
    ] {
        assert!(html.contains(text), "{text} is missing");
    }
    assert_eq!(html.matches("<table>").count(), 1, "no parameters, no table");
}

#[test]
fn the_page_asks_for_nothing_from_outside() {
    let html = page().html();
    assert_eq!(html.matches("://").count(), 1, "only the name space of the SVG");
    for word in ["<script", "<link", "@import", "url("] {
        assert!(!html.contains(word), "{word}");
    }
}

#[test]
fn equal_pages_give_equal_bytes() {
    assert_eq!(page().html(), page().html());
}
