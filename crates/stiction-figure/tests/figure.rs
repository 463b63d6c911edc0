//! What every picture must have, whatever it shows.

use stiction_figure::{Annotation, Error, Figure, Legend, Panel, Series, Style};

fn ramp(count: usize) -> Vec<f64> {
    (0..count).map(|i| i as f64).collect()
}

fn wave(count: usize) -> Vec<f64> {
    ramp(count).iter().map(|t| (0.05 * t).sin()).collect()
}

/// Reproducible numbers between 0 and 1 that look random.
fn scatter(count: usize) -> Vec<f64> {
    (0..count).map(|i| ((i as f64 * 12.9898).sin() * 43_758.545_3).fract().abs()).collect()
}

fn figure() -> Figure {
    let note = |a| {
        Panel::new("time (s)", "OP (%)").with(Series::steps("OP", ramp(300), wave(300))).note(a)
    };
    Figure::new("Title & <more>")
        .caption("What it \"shows\"")
        .with(
            Panel::new("time (s)", "PV (m³/h)")
                .title("upper")
                .with(Series::line("PV", ramp(300), wave(300)))
                .with(Series::dashed("SP", [0.0, 299.0], [0.0, 0.0]))
                .with(Series::points("samples", [10.0, 20.0], [0.5, -0.5])),
        )
        .with(note(Annotation::dimension((50.0, 0.0), (100.0, 0.0), "dead band", 20.0)))
        .with(note(Annotation::arrow("slip here", (50.0, 0.5), (100.0, 0.0))))
        .with(note(Annotation::x_band(50.0, 100.0, "start-up")))
        .with(note(Annotation::horizontal_line(0.3, "threshold")))
        .with(note(Annotation::vertical_line(120.0, "step")))
        .with(note(Annotation::text("plain\ntext", (200.0, 0.0))))
}

#[test]
fn all_that_is_written_is_in_the_svg() {
    let svg = figure().svg().unwrap();
    for text in [
        "Title &amp; &lt;more&gt;",
        "What it &quot;shows&quot;",
        "upper",
        "time (s)",
        "PV (m³/h)",
        "PV",
        "SP",
        "samples",
        "OP (%)",
        "dead band",
        "slip here",
        "start-up",
        "threshold",
        "step",
        "plain",
        "text",
        "250",
        "−1.0",
    ] {
        assert!(svg.contains(text), "{text} is missing");
    }
}

#[test]
fn equal_figures_give_equal_bytes() {
    assert_eq!(figure().svg().unwrap(), figure().svg().unwrap());
    assert_eq!(figure().png().unwrap(), figure().png().unwrap());
}

#[test]
fn an_svg_stands_alone_and_scales() {
    let svg = figure().svg().unwrap();
    assert!(svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\""));
    assert!(svg.contains("viewBox=\"0 0 800 "));
    assert_eq!(svg.matches("://").count(), 1, "only the name space looks like an address");
    assert!(!svg.contains("<script") && !svg.contains("url(http"));
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
}

#[test]
fn a_png_has_two_pixels_to_the_px() {
    let png = figure().png().unwrap();
    assert!(png.starts_with(b"\x89PNG\r\n\x1a\n"));
    assert_eq!(u32::from_be_bytes(png[16..20].try_into().unwrap()), 1600);
}

#[test]
fn a_png_shows_line_labels_and_title() {
    let line = Series::line("a", [0.0, 1.0], [0.0, 0.0]);
    let panel = Panel::new("abscissa", "ordinate").with(line).x_range(0.0, 1.0).y_range(-1.0, 1.0);
    let png = Figure::new("Title").with(panel).png().unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut rgb).unwrap();
    let (width, height) = (info.width as usize, info.height as usize);
    let blue = |row: usize| rgb[3 * (row * width + width / 2)..][..3] == [0x00, 0x72, 0xb2];
    // The line crosses the middle of the sheet once, and is about three pixels wide.
    let rows: Vec<usize> = (0..height).filter(|row| blue(*row)).collect();
    assert!((2..=4).contains(&rows.len()) && rows[rows.len() - 1] - rows[0] < 4, "{rows:?}");
    let dark = |columns: std::ops::Range<usize>, rows: std::ops::Range<usize>| {
        rows.flat_map(|row| columns.clone().map(move |column| 3 * (row * width + column)))
            .filter(|at| rgb[*at] < 0x60)
            .count()
    };
    let (middle, line) = (width / 2, rows[0]);
    assert!(dark(middle - 60..middle + 60, 10..60) > 300, "the title");
    assert!(dark(middle - 100..middle + 100, height - 50..height) > 200, "the label below");
    assert!(dark(0..50, line - 90..line + 90) > 200, "the label that reads upwards");
    assert_eq!(dark(0..50, 0..line - 120), 0, "nothing above it");
}

#[test]
fn malformed_figures_are_refused_in_sentences() {
    let panel = |series: Series| Panel::new("x", "y").with(series);
    let sound = || panel(Series::line("a", [0.0, 1.0], [0.0, 1.0]));
    let with = |panel: Panel| Figure::new("f").with(panel);
    let (nan, inf) = (f64::NAN, f64::INFINITY);
    let none: Vec<f64> = Vec::new();
    let cases: Vec<(Figure, &str)> = vec![
        (Figure::new("f"), "the figure \"f\" has no panels"),
        (with(Panel::new("x", "y")), "panel 0 has no series"),
        (
            with(sound()).with(panel(Series::line("a", none.clone(), none))),
            "series \"a\" of panel 1 has no samples",
        ),
        (with(panel(Series::line("a", [0.0, 1.0], [0.0]))), "has 2 x values, but 1 y values"),
        (
            with(panel(Series::points("a", [0.0, nan], [0.0, 1.0]))),
            "x value 1 of series \"a\" of panel 0 is NaN",
        ),
        (
            with(panel(Series::steps("a", [0.0, 1.0], [inf, 1.0]))),
            "y value 0 of series \"a\" of panel 0 is inf",
        ),
        (with(panel(Series::line("a", [0.0, 1.0], [-1e301, 1.0]))), "at most 1e300"),
        (with(sound().x_range(1.0, 1.0)), "the x range of panel 0 is 1 to 1"),
        (with(sound().y_range(2.0, 1.0)), "the y range of panel 0 is 2 to 1"),
        (with(sound().y_range(nan, 1.0)), "the y range of panel 0 is NaN to 1"),
        (with(sound().x_range(1e9, 1e9 + 1e-7)), "clearly larger"),
        (
            with(sound().note(Annotation::text("t", (0.0, nan)))),
            "annotation 0 of panel 0 contains NaN",
        ),
        (
            with(sound().note(Annotation::dimension((0.0, 0.0), (1.0, 1.0), "d", inf))),
            "contains inf",
        ),
        (with(sound()).columns(0), "columns of the figure is 0"),
        (with(sound()).width(nan), "width of the figure is NaN"),
        (with(sound()).panel_height(0.0), "panel_height of the figure is 0"),
    ];
    for (figure, sentence) in cases {
        let error = figure.svg().unwrap_err();
        assert!(error.to_string().contains(sentence), "\"{error}\" lacks \"{sentence}\"");
        assert!(figure.png().is_err());
    }
    assert_eq!(Figure::new("f").svg(), Err(Error::NoPanels { figure: "f".into() }));
}

#[test]
fn extreme_but_sound_figures_are_drawn() {
    let styles = [Style::Line, Style::Dashed, Style::Dotted, Style::Steps, Style::Points];
    for scale in [0.0, 1e-300, 1e-30, 1.0, 1e30, 1e299] {
        for offset in [0.0, -50.0, 1e15] {
            for style in styles {
                let values = |shift: f64| -> Vec<f64> {
                    wave(40).iter().map(|v| v * scale + offset + shift * scale).collect()
                };
                for x in [ramp(40), values(0.1)] {
                    let panel = Panel::new("x", "y")
                        .with(Series::new(style, "one", x.clone(), values(0.0)))
                        .with(Series::new(style, "two", x, values(0.3)));
                    let svg = Figure::new("")
                        .with(panel.clone())
                        .with(panel.equal_aspect())
                        .columns(2)
                        .svg()
                        .unwrap();
                    assert!(
                        !svg.contains("NaN") && !svg.contains("inf"),
                        "{scale} {offset} {style:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn text_cannot_break_the_document() {
    let nasty = "a\u{0}b</text><script>alert(1)</script> $x$ \\$ \"'&";
    let panel = Panel::new(nasty, nasty)
        .title(nasty)
        .with(Series::line(nasty, ramp(2), ramp(2)).colour(1000));
    let panel = panel.note(Annotation::horizontal_line(0.5, nasty)).legend(Legend::Above);
    let figure = Figure::new(nasty).caption(nasty).with(panel);
    let svg = figure.svg().unwrap();
    assert!(!svg.contains("<script") && !svg.contains('\u{0}'));
    assert!(svg.contains("$x$"), "dollars are no mathematics");
    assert!(figure.png().is_ok());
}

#[test]
fn long_series_make_small_files() {
    let (t, noise) = (ramp(60_000), scatter(60_000));
    let map: Vec<f64> = t.iter().zip(&noise).map(|(t, n)| (0.01 * t).cos() + 0.2 * n).collect();
    let sine: Vec<f64> = t.iter().map(|t| (0.01 * t).sin()).collect();
    for series in [
        Series::line("noise", &t[..], &noise[..]),
        Series::steps("noise", &t[..], &noise[..]),
        Series::line("map", &map[..], &sine[..]),
        Series::points("cloud", &map[..], &sine[..]),
    ] {
        let svg = Figure::new("").with(Panel::new("x", "y").with(series.clone())).svg().unwrap();
        assert!(svg.len() < 200_000, "{}: {} bytes", series.label, svg.len());
    }
}

#[test]
fn lines_differ_in_more_than_colour() {
    let line = |label: &str| Series::line(label, ramp(9), wave(9));
    let panel = Panel::new("x", "y").with(line("a")).with(line("b")).with(line("c"));
    let svg =
        Figure::new("").with(panel.with(Series::dashed("d", ramp(9), wave(9)))).svg().unwrap();
    let mut dashes: Vec<&str> = svg
        .split("stroke-dasharray=\"")
        .skip(1)
        .filter_map(|rest| rest.split('"').next())
        .collect();
    dashes.sort_unstable();
    dashes.dedup();
    assert_eq!(dashes.len(), 3, "{dashes:?}");
}

#[test]
fn panels_above_each_other_share_their_time_axis() {
    let panel = |to: usize| Panel::new("time (s)", "y").with(Series::line("a", ramp(to), wave(to)));
    let shared = Figure::new("").with(panel(100)).with(panel(101)).svg().unwrap();
    let alone = Figure::new("").with(panel(100)).with(panel(101)).columns(2).svg().unwrap();
    assert_eq!(shared.matches(">time (s)<").count(), 1);
    assert_eq!(alone.matches(">time (s)<").count(), 2);
}
