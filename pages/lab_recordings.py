"""Drives the lab's room of recordings in a real browser: Debian's Chromium, by Playwright.

python3 pages/lab_recordings.py COMMAND TARGET [FOLDER]

COMMAND is the built `stiction`; TARGET, cargo's target folder, is not used. With a FOLDER the screenshots are kept there.
"""

import csv
import json
import shutil
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path
from typing import Iterator

from playwright.sync_api import Browser, Page, sync_playwright

ROOT = Path(__file__).resolve().parent.parent
CHROMIUM = "/usr/bin/chromium"
WEB = ROOT / "crates" / "stiction-lab" / "web"
AXE = WEB / "node_modules" / "axe-core" / "axe.min.js"
SAMPLES = sorted(path for path in (ROOT / "samples").glob("*.csv") if path.stem != "truth")
WIDE = {"width": 1300, "height": 900}
PHONE = {"width": 390, "height": 844}
PROJECTOR = {"width": 1920, "height": 1080}
#: What the verdict on a stretch may take once it is chosen, s; the machine may be busy.
PATIENCE = 2.0


@contextmanager
def lab(command: Path, *given: str | Path, cwd: Path = ROOT) -> Iterator[str]:
    """A lab that runs, by its address."""
    run = subprocess.Popen([command, "lab", *given, "--no-open"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, cwd=cwd)
    try:
        yield run.stdout.readline().strip()
    finally:
        run.terminate()
        run.wait()


class Room:
    """A page in the lab that may ask nothing of anyone else, and complains of nothing."""

    def __init__(self, browser: Browser, address: str, size: dict, scheme: str = "light", state: str = "recordings"):
        self.page = browser.new_page(viewport=size, color_scheme=scheme)
        self.wrong: list[str] = []
        own = address.split("?")[0]
        self.page.on("request", lambda r: r.url.startswith((own, "data:", "blob:")) or self.wrong.append(f"asks for {r.url}"))
        self.page.on("pageerror", lambda error: self.wrong.append(str(error)))
        self.page.on("console", lambda said: said.type == "error" and self.wrong.append(said.text))
        self.page.add_init_script(path=AXE)
        self.page.goto(address)
        self.page.goto(f"{own}#/{state}")

    def verdict(self) -> str:
        """The verdict, once none is under way."""
        self.page.wait_for_selector(".verdict[aria-busy=false]")
        return self.page.locator(".verdict").inner_text()

    def holds(self, what: str) -> None:
        """No error, nothing wider than the screen, nothing that shuts anyone out."""
        assert not self.wrong, f"{what}: {self.wrong}"
        wide = self.page.evaluate("[document.documentElement.scrollWidth, innerWidth]")
        assert wide[0] <= wide[1], f"{what}: {wide[0]} px wide on {wide[1]}"
        found = self.page.evaluate("axe.run(document, {resultTypes: ['violations']})")
        serious = [v for v in found["violations"] if v["impact"] in ("serious", "critical")]
        told = [(v["id"], [n["html"][:200] for n in v["nodes"]][:3]) for v in serious]
        assert not told, f"{what}: {json.dumps(told, indent=1)}"


def drag(page: Page, a: float, b: float) -> None:
    """Drags over the trend, from one share of its width to another."""
    box = page.locator(".over").bounding_box()
    y = box["y"] + 0.3 * box["height"]
    page.mouse.move(box["x"] + a * box["width"], y)
    page.mouse.down()
    for k in range(1, 9):
        page.mouse.move(box["x"] + (a + (b - a) * k / 8) * box["width"], y)
    page.mouse.up()


def judged(command: Path, path: Path) -> dict:
    """What the command says."""
    said = subprocess.run([command, "diagnose", path, "--json"], check=True, capture_output=True, text=True, cwd=ROOT).stdout
    return json.loads(said)["loops"][0]


def samples(browser: Browser, command: Path, kept: Path) -> None:
    with lab(command, *SAMPLES) as address:
        room = Room(browser, address, WIDE)
        page = room.page
        text = room.verdict()
        page.wait_for_function("document.querySelectorAll('.open li a').length === 5")
        assert "sticks" in text and "more than 99" in text, text
        room.holds("a recording")
        page.screenshot(path=kept / "lab-recordings.png", full_page=True)

        # A stretch is chosen, and the verdict follows.
        began = time.monotonic()
        drag(page, 0.3, 0.7)
        page.wait_for_function("document.querySelector('.verdict h2').textContent.includes(': ')")
        stretch = room.verdict()
        took = time.monotonic() - began
        print(f"choosing a stretch, with the pointer's way: {took:.2f} s")
        assert took < PATIENCE and stretch != text
        page.wait_for_timeout(400)
        assert "from=" in page.url and "to=" in page.url, page.url

        # It is moved with keys.
        end = page.get_by_role("slider", name="End of the stretch")
        before = float(end.get_attribute("aria-valuenow"))
        end.focus()
        for _ in range(5):
            page.keyboard.press("ArrowRight")
        assert float(end.get_attribute("aria-valuenow")) > before
        room.verdict()

        # It zooms by the wheel, by keys and by buttons, and the address says so.
        page.locator(".over").hover()
        page.mouse.wheel(0, -400)
        page.wait_for_timeout(400)
        assert "zoom=" in page.url, page.url
        page.locator(".canvases").focus()
        page.keyboard.press("0")
        page.wait_for_timeout(400)
        assert "zoom=" not in page.url, page.url
        page.get_by_role("button", name="Show stretch").click()
        page.wait_for_timeout(400)
        held = page.url
        page.get_by_role("button", name="Show all").click()
        page.wait_for_timeout(100)
        page.screenshot(path=kept / "lab-recordings-stretch.png")

        # Kept beside the next.
        page.get_by_role("button", name="Keep to compare").click()
        page.get_by_role("button", name="Judge all").click()
        room.verdict()
        assert page.locator(".compare thead th").count() == 2
        room.holds("compared")
        page.evaluate("scrollTo(0, 0)")
        page.screenshot(path=kept / "lab-recordings-compared.png", full_page=True)

        # Every method has a picture, drawn when it is asked for.
        page.locator(".more > summary").click()
        fold = page.locator(".fold", has_text="Every method")
        fold.locator("summary").first.click()
        fold.locator(".method > summary").first.click()
        fold.locator("img").first.wait_for()
        assert fold.locator("img").count() > 5
        room.holds("all details")
        page.screenshot(path=kept / "lab-recordings-details.png", full_page=True)

        # A link leads back to the same.
        again = Room(browser, address, WIDE, state=held.split("#/")[1])
        again.verdict()
        assert again.page.locator(".handle.from").get_attribute("aria-valuenow") == page.evaluate(
            "url => new URLSearchParams(url.split('?')[1]).get('from')", held
        )
        again.page.close()

        # Each loop of the list.
        for each in SAMPLES[1:]:
            page.locator(".open li a", has_text=each.stem).click()
            page.wait_for_function("name => document.querySelector('.about h1')?.textContent.includes(name)", arg=each.stem)
            text = room.verdict()
            said = judged(command, each)
            assert said["verdict"]["grade"] in text, (each, said["verdict"]["grade"], text)
            room.holds(each.stem)
        page.close()
        for size, scheme, name in ((PHONE, "light", "phone"), (PROJECTOR, "dark", "dark")):
            shot = Room(browser, address, size, scheme)
            shot.verdict()
            shot.page.wait_for_timeout(300)
            shot.holds(name)
            shot.page.screenshot(path=kept / f"lab-recordings-{name}.png", full_page=True)
            shot.page.close()


def nothing_open(browser: Browser, command: Path, kept: Path) -> None:
    """The first use: it explains itself, an example opens, a file is dropped, its columns are said."""
    with tempfile.TemporaryDirectory() as folder, lab(command, cwd=Path(folder)) as address:
        room = Room(browser, address, WIDE)
        page = room.page
        page.get_by_text("Drop recordings of control loops here").wait_for()
        room.holds("nothing open")
        page.screenshot(path=kept / "lab-recordings-first.png")
        page.get_by_role("button", name="Try an example").click()
        assert "sticks" in room.verdict()
        rows = list(csv.reader(SAMPLES[0].open()))
        strange = "\n".join(",".join(["time", "a", "b", "c"] if k == 0 else row) for k, row in enumerate(rows))
        page.evaluate(
            """text => {
                const files = new DataTransfer();
                files.items.add(new File([text], 'strange.csv'));
                dispatchEvent(new DragEvent('dragover', {dataTransfer: files, cancelable: true}));
                dispatchEvent(new DragEvent('drop', {dataTransfer: files, cancelable: true}));
            }""",
            strange,
        )
        # Its columns have no names that tell; one says what they are.
        page.get_by_label("What c is").wait_for()
        room.holds("columns that are not known")
        page.screenshot(path=kept / "lab-recordings-columns.png")
        for column, role in zip("abc", rows[0][1:4]):
            page.get_by_label(f"What {column} is", exact=True).select_option(role)
        page.get_by_role("button", name="Read it so").click()
        assert "sticks" in room.verdict()
        room.holds("columns that were said")
        page.close()


def written(browser: Browser, command: Path) -> None:
    """What is written: an override and a mapping, beside the recording."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        path = folder / SAMPLES[0].name
        shutil.copy(SAMPLES[0], path)
        with lab(command, folder) as address:
            room = Room(browser, address, WIDE)
            page = room.page
            room.verdict()
            page.locator(".override > summary").click()
            page.get_by_label("The valve").select_option("does not stick")
            page.get_by_label("Because", exact=True).fill("new packing, stroked on the bench")
            page.get_by_label("Who says so").fill("J. Miller")
            page.get_by_role("button", name="Keep the override").click()
            page.get_by_text("Overruled by J. Miller").wait_for()
            page.get_by_role("button", name="Take it back").wait_for()
            room.holds("overruled")
            page.locator(".columns > summary").click()
            page.get_by_label("Controls").select_option("level")
            page.get_by_role("button", name="Save as mapping file").click()
            page.get_by_text("kept in").first.wait_for()
            with page.expect_download() as saved:
                page.get_by_role("link", name="Save the report").click()
            assert "<svg" in Path(saved.value.path()).read_text()
            assert not room.wrong, room.wrong
        assert "J. Miller" in (folder / "stiction-overrides.toml").read_text()
        assert 'type = "level"' in (folder / f"{path.name}.mapping.toml").read_text()
        assert path.read_bytes() == SAMPLES[0].read_bytes()


def main() -> None:
    command = Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        kept = Path(sys.argv[3]) if len(sys.argv) > 3 else Path(folder)
        kept.mkdir(parents=True, exist_ok=True)
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        samples(browser, command, kept)
        nothing_open(browser, command, kept)
        written(browser, command)
        browser.close()
    print("the room of recordings holds")


if __name__ == "__main__":
    main()
