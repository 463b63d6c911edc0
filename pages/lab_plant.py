"""Drives the room "Plant" of the lab in a real browser: Debian's Chromium, by Playwright.

python3 pages/lab_plant.py COMMAND PLANT [FOLDER]

COMMAND is the built `stiction`, PLANT a plant of 1,000 loops as `cargo run -p stiction-lab --example big_plant -- PLANT`
writes it, which is copied and left as it is. With a FOLDER the screenshots are kept there.
"""

import contextlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator
from pathlib import Path

from playwright.sync_api import Browser, BrowserContext, Page, sync_playwright

ROOT = Path(__file__).resolve().parent.parent
CHROMIUM = "/usr/bin/chromium"
AXE = (ROOT / "crates/stiction-lab/web/node_modules/axe-core/axe.min.js").read_text()
WIDE = {"width": 1300, "height": 900}
PHONE = {"width": 390, "height": 844}
PROJECTOR = {"width": 1920, "height": 1080}
#: What sorting 1,000 loops may take, and opening the room, s.
SORTING, OPENING = 0.2, 2.0
#: Counts the loops that pass what narrows the list down.
SHOWN = "[...document.querySelectorAll('.shown')].map(p => p.textContent)[0]"


@contextlib.contextmanager
def lab(command: Path, *arguments: str) -> Iterator[str]:
    """A lab that runs, and its address."""
    process = subprocess.Popen([command, "lab", "--no-open", *arguments], stdout=subprocess.PIPE, text=True)
    try:
        yield process.stdout.readline().strip()
    finally:
        process.send_signal(signal.SIGINT)
        began = time.monotonic()
        process.wait(10)
        assert time.monotonic() - began < 2, "Ctrl-C takes too long"


def browser_of(browser: Browser, address: str, size: dict[str, int] = WIDE, scheme: str = "light") -> tuple[BrowserContext, Page]:
    """A browser that has opened the lab, in which nothing may go wrong and nothing be asked of others."""
    context = browser.new_context(viewport=size, color_scheme=scheme)
    context.add_init_script(AXE)
    page = context.new_page()
    top = address.split("?")[0]
    page.on("request", lambda r: r.url.startswith((top, "data:", "blob:")) or sys.exit(f"asks for {r.url}"))
    page.on("pageerror", lambda error: sys.exit(f"an error of the page: {error}"))
    # Of loops that are made up no file holds anything, and the browser tells that, too.
    told = ("plant/trend", "plant/diagnose")
    page.on(
        "console",
        lambda said: said.type == "error"
        and not said.location["url"].endswith(told)
        and sys.exit(f"on the console: {said.text} {said.location}"),
    )
    page.goto(address)
    return context, page


def until(page: Page, holds: str, timeout: float = 15_000) -> None:
    """Waits until something holds; the policy of the page lets nobody but the browser itself evaluate a text."""
    end = time.monotonic() + timeout / 1000
    while not page.evaluate(holds):
        assert time.monotonic() < end, f"never: {holds}"
        time.sleep(0.03)


def go(page: Page, state: str = "") -> None:
    page.evaluate("state => { location.hash = '#/plant' + state }", state)
    page.wait_for_selector(".plant-room .views, .none", state="attached")


def holds(page: Page, what: str) -> None:
    """Nothing is wider than the screen, and axe finds nothing that is serious."""
    width = page.viewport_size["width"]
    wide = page.evaluate("document.documentElement.scrollWidth")
    assert wide <= width, f"{what}: {wide} px wide on {width}"
    found = page.evaluate("async () => (await axe.run()).violations")
    faults = [
        f"{fault['impact']} {fault['id']}: {fault['nodes'][0]['html'][:200]} ({len(fault['nodes'])})"
        for fault in found
        if fault["impact"] in ("serious", "critical")
    ]
    assert not faults, f"{what}: " + "\n".join(faults)
    minor = [f"{fault['impact']} {fault['id']}: {fault['nodes'][0]['html'][:150]}" for fault in found]
    if minor:
        print(f"{what}: {minor}")


def entries(plant: Path) -> list[dict]:
    path = plant / "log.toml"
    return tomllib.loads(path.read_text())["entry"] if path.exists() else []


def without_plant(browser: Browser, command: Path, kept: Path) -> None:
    with lab(command) as address:
        context, page = browser_of(browser, address)
        go(page)
        assert "stiction plant demo" in page.locator(".none").inner_text()
        holds(page, "without a plant")
        page.screenshot(path=kept / "lab-plant-none.png")
        context.close()


def scanned(browser: Browser, command: Path, plant: Path, kept: Path) -> None:
    """A plant that was not scanned so far: the scan is begun, stopped, begun again, and told to its end."""
    with lab(command, "--plant", str(plant)) as address:
        context, page = browser_of(browser, address)
        page.evaluate("location.hash = '#/plant'")
        page.wait_for_selector("text=Nothing was judged so far")
        holds(page, "before the scan")
        page.get_by_role("button", name="Scan what is new").click()
        page.wait_for_selector("progress")
        page.screenshot(path=kept / "lab-plant-scan.png")
        page.get_by_role("button", name="Stop").click()
        page.wait_for_selector("text=Scan what is new", timeout=60_000)
        page.get_by_role("button", name="Scan what is new").click()
        page.wait_for_selector("text=/windows judged|Nothing was new/", timeout=120_000)
        page.wait_for_selector("tr[data-loop]")
        rows = page.locator("tr[data-loop]").count()
        assert rows == 8, rows
        context.close()


def room(browser: Browser, command: Path, plant: Path, kept: Path) -> None:
    with lab(command, "--plant", str(plant)) as address:
        context, page = browser_of(browser, address)
        began = time.monotonic()
        go(page)
        page.wait_for_selector("tr[data-loop]")
        print(f"opening a plant of 1,000 loops: {time.monotonic() - began:.2f} s")
        began = time.monotonic()
        page.reload()
        page.wait_for_selector("tr[data-loop]")
        again = time.monotonic() - began
        print(f"again: {again:.2f} s")
        assert again < OPENING
        page.screenshot(path=kept / "lab-plant.png")
        holds(page, "the list")
        rows = page.locator("tr[data-loop]")
        assert "1000" in page.evaluate(SHOWN), page.evaluate(SHOWN)
        assert rows.count() < 100, "rows that nobody sees are not made"

        # Sorting, by the clock of the page: from the click to the frame in which it is drawn.
        timed = """async (key) => {
          const button = document.querySelector(`.c-${key} button`);
          const began = performance.now();
          button.click();
          await new Promise(done => requestAnimationFrame(() => setTimeout(done)));
          return (performance.now() - began) / 1000;
        }"""
        for key in ("p", "name", "grade", "s", "name", "action"):
            took = page.evaluate(timed, key)
            assert took < SORTING, f"sorting by {key} took {took:.2f} s"
        print(f"sorting 1,000 loops: {took:.3f} s")
        page.evaluate(timed, "p")
        assert page.locator("th[aria-sort=descending]").count() == 1
        surest = rows.first.locator(".c-p").inner_text()
        assert surest == "> 99" or int(surest) > 95, surest

        # Search, filters and the address.
        page.get_by_role("searchbox").fill("fic20")
        until(page, f"/^\\d+ of 1000/.test({SHOWN})")
        some = page.evaluate(SHOWN)
        until(page, "location.hash.includes('search=fic20')")
        page.reload()
        page.wait_for_selector("tr[data-loop]")
        assert page.evaluate(SHOWN) == some
        page.get_by_role("button", name="Clear filters").click()
        page.get_by_label("Area").select_option("Crude")
        page.get_by_label("Unit").select_option("C-101")
        until(page, "[...document.querySelectorAll('.c-name small')].every(of => of.textContent === 'Crude · C-101')")
        page.get_by_role("button", name="Clear filters").click()

        # Keys alone: into the list, down, and into a loop.
        rows.first.locator("a").focus()
        for _ in range(40):
            page.keyboard.press("ArrowDown")
        until(page, "document.activeElement?.closest('tr')?.getAttribute('aria-rowindex') === '42'")
        name = page.evaluate("document.activeElement.textContent")
        page.keyboard.press("Enter")
        page.wait_for_selector(".panel h2")
        assert page.locator(".panel h2").inner_text() == name
        page.keyboard.press("Escape")
        page.wait_for_selector(".panel", state="detached") if page.evaluate(
            "!!document.activeElement.closest('.panel')"
        ) else page.get_by_role("button", name="Close").click()

        views(page, kept)
        loop(page, plant, kept)
        both(browser, address, page, plant)
        context.close()
        for size, scheme, kind in ((PHONE, "light", "phone"), (PROJECTOR, "light", "projector"), (WIDE, "dark", "dark"), (PHONE, "dark", "phone-dark")):
            context, page = browser_of(browser, address, size, scheme)
            for view, wanted in (
                ("", "tr[data-loop]"),
                ("?view=map", "svg.map [data-k]"),
                ("?view=areas", ".place"),
                ("?view=groups", ".card"),
                ("?view=changes", ".changes li"),
                ("?view=orders", ".order"),
                ("?view=data", ".card"),
                ("?loop=FIC1001&view=loops", ".panel .u-over"),
            ):
                go(page, view)
                page.wait_for_selector(wanted)
                if "loop=" in view:
                    page.wait_for_selector("text=Judged anew")
                holds(page, f"{kind} {view}")
                name = view.split("=")[1].split("&")[0] if view else "list"
                page.screenshot(path=kept / f"lab-plant-{kind}-{name}.png", full_page="loop" in view)
            context.close()


def views(page: Page, kept: Path) -> None:
    """Map, areas, groups, changes, orders, data."""
    links = page.locator("nav.views")
    links.get_by_role("link", name="Map").click()
    tiles = page.locator("svg.map [data-k]")
    tiles.first.wait_for()
    assert tiles.count() == 1000
    page.locator("svg.map [tabindex='0']").focus()
    first = page.evaluate("document.activeElement.dataset.k")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowDown")
    assert page.evaluate("document.activeElement.dataset.k") != first
    holds(page, "the map")
    page.screenshot(path=kept / "lab-plant-map.png")
    told = page.evaluate("document.activeElement.getAttribute('aria-label')")
    page.keyboard.press("Enter")
    page.wait_for_selector(".panel h2")
    assert told.startswith(page.locator(".panel h2").inner_text())
    page.get_by_role("button", name="Close").click()
    for view, wanted in (("Areas", ".place"), ("Groups", ".views"), ("Changes", ".changes li"), ("Work orders", ".order"), ("Data", ".card")):
        links.get_by_role("link", name=view).click()
        page.wait_for_selector(wanted)
        holds(page, view)
        page.screenshot(path=kept / f"lab-plant-{view.split()[-1].lower()}.png")
    links.get_by_role("link", name="Areas").click()
    page.get_by_role("link", name="Reformer").click()
    until(page, "[...document.querySelectorAll('.c-name small')].length > 0")
    assert "Reformer" in page.locator(".c-name small").first.inner_text()
    page.go_back()
    page.wait_for_selector(".areas")
    links.get_by_role("link", name="Loops").click()


def loop(page: Page, plant: Path, kept: Path) -> None:
    """A loop: its days, the trend from the files, the verdict, and what is said of it."""
    page.get_by_role("button", name="Clear filters").click() if page.get_by_role("button", name="Clear filters").count() else None
    page.get_by_role("searchbox").fill("fic1001")
    page.locator("tr[data-loop=FIC1001] a").click()
    page.wait_for_selector(".panel .u-over")
    page.wait_for_selector("text=Judged anew")
    assert page.locator(".panel .u-over").count() == 2
    days = page.locator(".history [role=button]")
    assert days.count() == 2
    holds(page, "a loop")
    page.screenshot(path=kept / "lab-plant-loop.png", full_page=True)
    # Days by key; the address has them.
    days.nth(1).focus()
    page.keyboard.press("ArrowLeft")
    until(page, "location.hash.includes('day=2026-03-02')")
    page.wait_for_selector("text=Trend: 2026-03-02")
    page.wait_for_selector(".panel .u-over")
    before = page.locator(".trend p.soft").inner_text()
    page.get_by_role("button", name="Zoom in").click()
    until(page, f"document.querySelector('.trend p.soft')?.textContent !== {before!r}")
    box = page.locator(".panel .u-over").first.bounding_box()
    page.mouse.move(box["x"] + 50, box["y"] + 50)
    page.mouse.down()
    page.mouse.move(box["x"] + 200, box["y"] + 60, steps=4)
    page.mouse.up()
    page.wait_for_timeout(500)
    page.screenshot(path=kept / "lab-plant-zoom.png")
    page.get_by_role("button", name="Whole day").click()

    # A note, a repair, a snooze and an override, as the command writes them.
    said = page.locator("form.said")
    said.get_by_label("Text").fill("hunts since the turnaround <b>\"x\"</b>")
    said.get_by_label("By").fill("J. Miller")
    said.get_by_role("button", name="Enter").click()
    page.wait_for_selector("text=Kept in log.toml")
    assert entries(plant)[-1]["kind"] == "note" and entries(plant)[-1]["by"] == "J. Miller"
    said.get_by_label("Repair").check()
    said.get_by_label("Text").fill("new packing")
    said.get_by_label("Day", exact=True).fill("2026-03-03")
    said.get_by_role("button", name="Enter").click()
    page.wait_for_selector(".history .events .repair")
    said.get_by_label("Override").check()
    said.get_by_label("The valve").select_option("does not stick")
    said.get_by_label("Reason").fill("stroked on the bench")
    said.get_by_role("button", name="Enter").click()
    page.wait_for_selector(".overruled")
    said.get_by_label("Snooze").check()
    said.get_by_label("Until").fill("2030-01-01")
    said.get_by_role("button", name="Enter").click()
    page.wait_for_selector("tr[data-loop=FIC1001]", state="detached")
    assert [entry["kind"] for entry in entries(plant)] == ["note", "repair", "override", "snooze"], entries(plant)
    assert page.locator(".entries li").count() == 4
    page.screenshot(path=kept / "lab-plant-said.png", full_page=True)
    page.get_by_label("List").select_option("snoozed")
    page.wait_for_selector("tr[data-loop=FIC1001]")
    page.get_by_role("button", name="Close").click()


def both(browser: Browser, address: str, page: Page, plant: Path) -> None:
    """Two windows at once: what one enters the other shows, and nothing is lost."""
    context, other = browser_of(browser, address)
    for each in (page, other):
        go(each, "?loop=FIC1002")
        each.wait_for_selector(".panel .u-over")
    before = len(entries(plant))
    for k in range(5):
        for each, who in ((page, "one"), (other, "two")):
            each.locator("form.said").get_by_label("Text").fill(f"{who} {k}")
        for each in (page, other):
            each.locator("form.said").get_by_role("button", name="Enter").click(no_wait_after=True)
        for each in (page, other):
            until(each, "document.querySelector('form.said input[type=text]').value === ''")
    texts = [entry["text"] for entry in entries(plant)[before:]]
    assert sorted(texts) == sorted(f"{who} {k}" for who in ("one", "two") for k in range(5)), texts
    for each in (page, other):
        until(each, "document.querySelectorAll('.entries li').length === 10", timeout=15_000)
    context.close()


def main() -> None:
    command, plant = (Path(each).resolve() for each in sys.argv[1:3])
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        folder = Path(folder)
        kept = Path(sys.argv[3]) if len(sys.argv) > 3 else folder
        kept.mkdir(parents=True, exist_ok=True)
        shutil.copytree(plant, folder / "big")
        (folder / "big" / "log.toml").unlink(missing_ok=True)
        subprocess.run([command, "plant", "demo", "--loops", "8", "--days", "2", "-o", folder / "small"], check=True)
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        without_plant(browser, command, kept)
        scanned(browser, command, folder / "small", kept)
        room(browser, command, folder / "big", kept)
        browser.close()
    print("the room holds")


if __name__ == "__main__":
    main()
