"""What a prompt and a notebook show: a few lines, and cards that need no network and hide nothing that is hostile."""

import re
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest
import stiction
from stiction import _html
from stiction._result import LONGEST, Result

RUN = stiction.simulate("samples/sticky-flow")
VOID = {"br", "img", "input", "hr", "meta", "link"}


class Nesting(HTMLParser):
    """Tags that are opened are closed, in their order."""

    def __init__(self):
        super().__init__()
        self.open, self.texts = [], []

    def handle_starttag(self, tag, attributes):
        assert tag not in VOID | {"script", "style"}
        self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        pass

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, text):
        self.texts.append(text)


def parsed(html):
    page = Nesting()
    page.feed(html)
    page.close()
    assert not page.open
    return page


@pytest.fixture(scope="module")
def found():
    loop = stiction.recording(RUN.op, RUN.pv, RUN.sp, sample_time=1, name="FIC101")
    return stiction.diagnose(loop)


@pytest.fixture(scope="module")
def samples():
    return stiction.diagnose_all(map(stiction.datasets.load, stiction.datasets.names()), detectors="none")


def test_a_diagnosis_is_reported_in_five_lines(found, samples):
    shown = repr(found)
    assert shown.startswith("<Diagnosis of FIC101 (flow): sticks (probability of sticking: 99 %)")
    assert f"S {found.stiction.S.value:.2g} % of span (" in shown and "swing: every 73.9 s" in shown
    for each in samples:
        assert len(repr(each).splitlines()) <= 5 and len(repr(each)) <= LONGEST
    assert "likeliest other cause: external oscillation (" in repr(samples[1])


def test_so_are_all_large_results(found):
    fitted = stiction.fit(stiction.datasets.load("FIC101-sticky"))
    large = [
        found,
        *found,
        stiction.what_if("paper/closed-loop", methods=["knocker"]),
        stiction.compensation.compare_compensators("paper/closed-loop", methods=["knocker"]),
        stiction.population(1)[0],
        stiction.cycles.limit_cycles("paper/closed-loop"),
        fitted,
        *fitted,
        fitted.prospects(),
        stiction.oscillations.oscillation(RUN.pv - RUN.sp, 1),
        stiction.fusion.verdict_model(),
    ]
    for each in large:
        if isinstance(each, Result):
            assert len(repr(each).splitlines()) <= 5 and len(repr(each)) <= LONGEST, type(each)


def test_small_results_show_their_attributes():
    assert repr(stiction.diagnosis.Limit(value=1.5, confidence=0.95)) == "Limit(value=1.5, confidence=0.95)"
    assert repr(stiction.diagnosis.Fault(name="x", told_by="y" * 200)).endswith("told_by='" + "y" * 200 + "')")


def test_a_card_tells_verdict_numbers_and_the_first_step(found):
    page = parsed(found._repr_html_())
    text = " ".join(page.texts)
    for words in ("FIC101 (flow)", "sticks (probability of sticking: 99 %)", "every 73.9 s", "First:"):
        assert words in text
    assert found.verdict.confirm.summary in text
    assert f"{found.stiction.S.value:.2g} % of span" in text


def test_without_a_test_the_first_step_is_about_the_likeliest_cause(samples):
    disturbed = samples[1]
    wandering = stiction.diagnose(stiction.datasets.load("LIC104-quantised").split(5000)[2], detectors="none")
    [cause, *_] = disturbed.verdict.alternatives
    assert cause.because[1:] in " ".join(parsed(disturbed._repr_html_()).texts)
    assert wandering.verdict.alternatives[0].cause == "normal operation" and "First:" not in wandering._repr_html_()


def test_the_trend_is_a_picture_with_units_and_a_label(found):
    [picture] = re.findall(r"<svg.*</svg>", found._repr_html_())
    root = ElementTree.fromstring(picture)
    assert root.get("role") == "img" and "FIC101" in root.get("aria-label")
    texts = ["".join(each.itertext()) for each in root.iter("{http://www.w3.org/2000/svg}text")]
    assert {"PV and SP (its units)", "OP (% of span)", "time (min)"} <= set(texts)
    lines = [each.get("points").split() for each in root.iter("{http://www.w3.org/2000/svg}polyline")]
    assert len(lines) == 3 and all(2 <= len(points) <= 1202 for points in lines)
    assert "http" not in picture.replace("http://www.w3.org/2000/svg", "")


def test_thinning_keeps_the_extremes():
    t = np.arange(100_000.0)
    signal = np.sin(t / 50)
    signal[[777, 54_321]] = 9, -9
    points = _html._thinned(t, signal)
    assert len(points) <= 1202 and (777.0, 9.0) in points and (54_321.0, -9.0) in points
    assert points == sorted(points) and points[0][0] == 0 and points[-1][0] == 99_999
    assert _html._thinned(t[:3], np.array([1, np.nan, 2])) == [(0, 1), (2, 2)]


def test_texts_are_escaped():
    hostile = '<script>alert("1")</script>&'
    loop = stiction.recording(RUN.op, RUN.pv, RUN.sp, RUN.vp, sample_time=1, name=hostile, start=1.7e9)
    html = stiction.diagnose(loop, detectors="none")._repr_html_()
    assert "<script" not in html and hostile in " ".join(parsed(html).texts)
    assert "time (min) since 2023-11-14 22:13:20 UTC" in html
    assert "<script" not in _html.table({hostile: [hostile]})


def test_without_a_segment_there_is_a_card_without_a_trend():
    dead = stiction.diagnose(stiction.recording(np.full(50, 50.0), sample_time=1), detectors="none")
    parsed(dead._repr_html_())
    assert len(repr(dead).splitlines()) <= 5


def test_a_constant_signal_has_an_axis():
    t = np.arange(10.0)
    ElementTree.fromstring(_html.trend("flat", t, [("PV (m)", [("PV", np.full(10, 3.0))])]))
    ElementTree.fromstring(_html.trend("lost", t, [("PV (m)", [("PV", np.full(10, np.nan))])]))


@pytest.mark.parametrize(
    "low, high, ticks", [(0, 10, [0, 5, 10]), (42.9, 48.1, [44, 46, 48]), (-0.3, 0.3, [-0.2, 0, 0.2]), (2, 2, [2])]
)
def test_ticks_are_round(low, high, ticks):
    assert _html._ticks(low, high, 4) == pytest.approx(ticks)


@pytest.mark.parametrize("page", ["#ffffff", "#111111"])
def test_lines_stand_out_on_light_and_on_dark_pages(page):
    def luminance(colour):
        parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
        return float(np.dot([0.2126, 0.7152, 0.0722], linear))

    for colour in set(_html._COLOURS.values()) - {"currentColor"}:
        bright, dark = sorted([luminance(colour), luminance(page)], reverse=True)
        assert (bright + 0.05) / (dark + 0.05) > 3, colour


def test_a_table_shows_its_first_rows(samples):
    html = stiction.summary_table(samples)._repr_html_()
    page = parsed(html)
    assert "FIC101-sticky" in page.texts and "verdict" in page.texts and html.count("<tr>") == 6
    many = _html.table({"n": list(range(100)), "name": [None] * 100})
    assert "80 more rows" in many and many.count("<tr>") == 21


def test_what_is_left_out_is_marked():
    long = stiction.diagnosis.Relation(mismatch="x", because="y" * 500, remedy="z")
    assert repr(long) == f"Relation(mismatch='x', because='{'y' * 30}...', remedy='z')"
    of = stiction.valve_test.TestPlan
    many = of(**{**dict.fromkeys(of.__dataclass_fields__), "instructions": ["wait " * 50] * 3})
    assert repr(many).endswith("instructions=<3 items>)")
