"""Checks the pages in a real browser, Debian's Chromium with Playwright.

python3 pages/check.py COMMAND TARGET [FOLDER]

COMMAND is the built `stiction`. TARGET is Cargo's target folder. The tests of the report leave an index of 1,000
loops in it, and those of the plant the page of a week of 1,000 loops. With a FOLDER the screenshots are saved
there. Copies of `FIC101-sticky.png` and `index.png` are `docs/figures/report.png` and `docs/figures/index.png`.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

from playwright.sync_api import Browser, Page, sync_playwright

ROOT = Path(__file__).resolve().parent.parent
CHROMIUM = "/usr/bin/chromium"
SAMPLES = sorted(path.relative_to(ROOT) for path in (ROOT / "samples").glob("*.csv") if path.stem != "truth")
#: Time limit to open, sort or search an index of 1,000 loops, s.
PATIENCE = 3.0
WIDE = {"width": 1300, "height": 900}
PHONE = {"width": 390, "height": 844}
#: Pages of the documentation with a screenshot.
SHOTS = [
    (name, size, scheme)
    for name in ("index.html", "gallery.html", "gallery/FIC211.html", "commands.html", "paper.html")
    for size, scheme in ((WIDE, "light"), (PHONE, "light"), (WIDE, "dark"))
]


def opened(browser: Browser, path: Path, width: int, height: int, scheme: str = "light") -> Page:
    """A page that may load only itself."""
    page = browser.new_page(viewport={"width": width, "height": height}, color_scheme=scheme)
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.on("pageerror", lambda error: sys.exit(f"{path.name}: {error}"))
    page.goto(path.as_uri())
    assert asked == [path.as_uri()], f"{path.name} asks for {asked}"
    return page


def overlap(page: Page, first: str, second: str) -> bool:
    """Whether two elements overlap."""
    a, b = (page.locator(each).first.bounding_box() for each in (first, second))
    return not (
        a["x"] + a["width"] <= b["x"]
        or b["x"] + b["width"] <= a["x"]
        or a["y"] + a["height"] <= b["y"]
        or b["y"] + b["height"] <= a["y"]
    )


def report(browser: Browser, path: Path, kept: Path) -> None:
    page = opened(browser, path, 1300, 768)
    page.screenshot(path=kept / f"{path.stem}.png")
    # Verdict, action and the whole trend are on the first screen.
    for each in (".verdict .badge", ".said ol", ".seen figure"):
        box = page.locator(each).first.bounding_box()
        assert box["y"] + box["height"] <= 768, f"{path.name}: {each} is not on the first screen"
    assert not overlap(page, ".said", ".seen"), path.name
    assert page.evaluate("document.documentElement.scrollWidth") <= 1300, path.name
    unnamed = page.evaluate(
        """[...document.querySelectorAll('svg[role=img]')].filter(s => !s.getAttribute('aria-label')
           && !document.getElementById(s.getAttribute('aria-labelledby'))?.textContent.trim()).length"""
    )
    assert unnamed == 0, f"{path.name}: {unnamed} figures have no name"
    # Folds open with keys.
    folds = page.locator("section.loop > details")
    assert folds.count() >= 5 and page.locator("details[open]").count() == 0, path.name
    folds.first.locator("summary").first.focus()
    page.keyboard.press("Enter")
    assert page.locator("details[open]").count() == 1, path.name
    page.keyboard.press("Enter")
    # The trend zooms to the last cycle, has a cursor for keys, and zooms out again.
    trend = page.locator(".seen figure svg.live").first
    if page.locator("[data-cycles='1']").count():
        page.locator("[data-cycles='1']").click()
        assert trend.locator(".zoomed").count() > 0, path.name
        page.locator("[data-cycles='']").click()
        assert trend.locator(".zoomed").count() == 0, path.name
    trend.focus()
    page.keyboard.press("ArrowRight")
    assert page.locator(".tip").is_visible(), path.name
    page.keyboard.press("Escape")
    pages = page.pdf(format="A4").count(b"/Type /Page\n")
    assert 1 <= pages <= 2, f"{path.name}: {pages} pages of paper"
    page.close()

    phone = opened(browser, path, 390, 844)
    assert phone.evaluate("document.documentElement.scrollWidth") <= 390, f"{path.name}: wider than a phone"
    phone.screenshot(path=kept / f"{path.stem}-phone.png")
    phone.close()
    dark = opened(browser, path, 1300, 768, "dark")
    shade = dark.evaluate("getComputedStyle(document.querySelector('.sheet')).backgroundColor")
    assert shade == "rgb(23, 24, 27)", f"{path.name}: {shade} in the dark"
    dark.screenshot(path=kept / f"{path.stem}-dark.png")
    dark.close()


def index(browser: Browser, path: Path, kept: Path) -> None:
    began = time.monotonic()
    page = opened(browser, path, 1300, 768)
    rows = page.locator("tbody tr:not([hidden])")

    def within(what: str, wanted: int) -> None:
        nonlocal began
        assert rows.count() == wanted, f"{what}: {rows.count()} rows, not {wanted}"
        took = time.monotonic() - began
        print(f"{what} of 1,000 loops: {took:.2f} s")
        assert took < PATIENCE, f"{what} took {took:.2f} s"
        began = time.monotonic()

    within("opening an index", 1000)
    page.screenshot(path=kept / "index-of-1000.png")
    began = time.monotonic()
    head = page.get_by_role("button", name="probability of sticking")
    head.click()
    assert "less than 1 %" in rows.first.inner_text()
    head.click()
    assert "more than 99 %" in rows.first.inner_text()
    within("sorting", 1000)
    page.get_by_placeholder("words in any column").fill("u3-fc")
    within("searching", 125)
    page.get_by_placeholder("words in any column").fill("")
    chip = page.locator("[data-only='probably sticks']")
    chip.focus()
    page.keyboard.press("Enter")
    assert chip.get_attribute("aria-pressed") == "true"
    within("narrowing down", 111)
    page.keyboard.press("Enter")
    page.locator("[data-first]").check()
    assert 800 < rows.count() < 1000, rows.count()
    assert page.evaluate("document.documentElement.scrollWidth") <= 1300
    page.close()


def plant(browser: Browser, path: Path, kept: Path) -> None:
    """Checks opening, sorting, filters and search on the page of a plant's week with 1,000 loops."""
    began = time.monotonic()
    page = opened(browser, path, 1300, 900)
    rows = page.locator("table.loops tbody tr:not([hidden])")

    def within(what: str, wanted: int, limit: float = PATIENCE) -> None:
        nonlocal began
        assert rows.count() == wanted, f"{what}: {rows.count()} rows, not {wanted}"
        took = time.monotonic() - began
        print(f"{what} of a plant of 1,000 loops: {took:.2f} s")
        assert took < limit, f"{what} took {took:.2f} s"
        began = time.monotonic()

    within("opening a week", 999)  # one is snoozed
    print(f"{path.name}: {path.stat().st_size / 1000:.0f} kB")
    assert path.stat().st_size <= 1_500_000
    page.screenshot(path=kept / "plant.png")
    assert page.locator(".changes li").count() == 20 and page.locator("svg.map [data-k]:visible").count() == 1000
    began = time.monotonic()
    page.get_by_role("button", name="Prob., %").click()
    within("sorting", 999)
    assert page.locator("th[aria-sort=ascending]").count() == 1
    page.get_by_role("button", name="Priority").click()
    page.get_by_role("button", name="Priority").click()
    began = time.monotonic()
    page.get_by_placeholder("words in any column").fill("fic1029")
    within("finding", 1)
    assert "repair" in rows.first.inner_text()
    page.get_by_placeholder("words in any column").fill("")
    # Filters by action, area and unit with keys: OR within a filter, AND between filters.
    for place in ("[data-only=repair]", "[data-only=Crude]"):
        page.locator(place).focus()
        page.keyboard.press("Enter")
        assert page.locator(place).get_attribute("aria-pressed") == "true"
    some = rows.count()
    assert 0 < some < 999 and all("Crude" in text for text in rows.locator("th").all_inner_texts())
    page.locator("[data-only=new]").click()
    assert 0 < rows.count() < some
    for place in ("[data-only=new]", "[data-only=Crude]", "[data-only=repair]", "[data-only=open]"):
        page.locator(place).click()
    began = time.monotonic()
    page.locator("[data-only=snoozed]").click()
    within("the snoozed", 1)
    page.locator("[data-only=snoozed]").click()
    assert rows.count() == 1000
    page.locator("svg.map [data-k='3']:visible").click()
    assert page.locator("#k3.found").is_visible()
    assert page.evaluate("document.documentElement.scrollWidth") <= 1300
    page.close()
    for size, scheme in ((PHONE, "light"), (WIDE, "dark")):
        shot = opened(browser, path, size["width"], size["height"], scheme)
        assert shot.evaluate("document.documentElement.scrollWidth") <= size["width"], f"{path.name}: too wide"
        shot.locator("#loops").evaluate("each => each.scrollIntoView()")
        shot.screenshot(path=kept / f"plant-{scheme}.png")
        shot.close()


def site(browser: Browser, command: Path, folder: Path, kept: Path) -> None:
    """Checks the documentation: every page wide and narrow, search, keys, and the dark theme."""
    began = time.monotonic()
    subprocess.run([command, "docs", "-o", folder], check=True, capture_output=True)
    print(f"writing the documentation: {time.monotonic() - began:.1f} s")
    pages = sorted(folder.rglob("*.html"))
    top = folder.as_uri() + "/"
    page = browser.new_page(viewport=WIDE)
    wrong: list[str] = []
    page.on("request", lambda request: request.url.startswith(top) or wrong.append(f"asks for {request.url}"))
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("console", lambda said: said.type == "error" and wrong.append(said.text))
    for path in pages:
        here = str(path.relative_to(folder))
        page.goto(path.as_uri())
        assert not wrong, f"{here}: {wrong}"
        for size in (WIDE, PHONE):
            page.set_viewport_size(size)
            width = page.evaluate("document.documentElement.scrollWidth")
            assert width <= size["width"], f"{here}: {width} px wide on {size['width']}"
        page.set_viewport_size(WIDE)
        mute = page.evaluate("[...document.images].filter(i => !i.alt || !i.naturalWidth).map(i => i.src)")
        assert not mute, f"{here}: images without words or pixels: {mute}"
    print(f"documentation: {len(pages)} pages hold, {sum(p.stat().st_size for p in folder.rglob('*.*')) / 1e6:.1f} MB")

    # The search opens a page from any page, with keys only.
    page.goto((folder / "gallery" / "FIC201.html").as_uri())
    page.keyboard.press("/")
    page.keyboard.type("dead band")
    page.wait_for_selector("#found a")
    assert "dead band" in page.locator("#found a").first.inner_text().lower()
    page.screenshot(path=kept / "site-search.png")
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    page.wait_for_url(lambda url: "FIC201" not in url)
    page.keyboard.press("/")
    page.keyboard.type("nothing has this zzz")
    page.wait_for_selector("#found p")
    page.keyboard.press("Escape")
    assert page.locator("#found").is_hidden()

    # The first tab stop skips the table of contents, and every focused element is visible.
    page.goto((folder / "index.html").as_uri())
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.className") == "skip"
    assert page.locator(".skip").bounding_box()["x"] >= 0
    page.keyboard.press("Enter")
    assert page.evaluate("location.hash") == "#content"
    page.keyboard.press("Tab")
    assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") != "none"
    assert page.evaluate("!!document.activeElement.closest('main')")
    page.locator(".copy").first.click()
    page.wait_for_function("document.querySelector('.copy').textContent === 'Copied'")
    assert not wrong, wrong
    page.close()

    for name, size, scheme in SHOTS:
        shot = browser.new_page(viewport=size, color_scheme=scheme)
        shot.goto((folder / name).as_uri())
        shade = shot.evaluate("getComputedStyle(document.body).backgroundColor")
        assert shade == ("rgb(23, 24, 27)" if scheme == "dark" else "rgb(255, 255, 255)"), f"{name}: {shade}"
        kind = f"{'phone' if size == PHONE else 'wide'}-{scheme}"
        shot.screenshot(path=kept / f"site-{name.replace('/', '-').removesuffix('.html')}-{kind}.png")
        shot.close()


def diagnose(command: Path, files: list[Path], report: Path) -> None:
    subprocess.run([command, "diagnose", *files, "--report", report], check=True, capture_output=True, cwd=ROOT)


def main() -> None:
    command, target = (Path(each).resolve() for each in sys.argv[1:3])
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        folder = Path(folder)
        kept = Path(sys.argv[3]) if len(sys.argv) > 3 else folder
        kept.mkdir(parents=True, exist_ok=True)
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        for sample in SAMPLES:
            path = folder / f"{sample.stem}.html"
            diagnose(command, [sample], path)
            report(browser, path, kept)
            print(f"{path.name}: {path.stat().st_size / 1000:.0f} kB, holds")
        diagnose(command, SAMPLES, folder / "many")
        many = opened(browser, folder / "many" / "index.html", 1300, 768)
        many.set_viewport_size({"width": 1300, "height": 370})
        many.screenshot(path=kept / "index.png")
        many.locator("tbody a").first.click()
        assert many.locator("nav.home a").get_attribute("href") == "./../index.html"
        many.locator("nav.home a").click()
        assert many.locator("tbody tr").count() == len(SAMPLES)
        many.close()
        index(browser, target / "tmp" / "index-of-1000.html", kept)
        plant(browser, target / "tmp" / "plant-of-1000.html", kept)
        site(browser, command, folder / "site", kept)
        browser.close()


if __name__ == "__main__":
    main()
