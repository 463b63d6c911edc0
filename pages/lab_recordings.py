"""Checks the lab's room of recordings in a real browser.

python3 pages/lab_recordings.py COMMAND [FOLDER]

With a FOLDER the screenshots are saved there.
"""

import csv
import json
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from lab import CHROMIUM, FRAMES, LOOKS, ROOT, WIDE, Lab, opened, running, sound, until
from playwright.sync_api import Browser, Page, sync_playwright

SAMPLES = sorted(path for path in (ROOT / "samples").glob("*.csv") if path.stem != "truth")
#: Time limit for the verdict on a selected stretch, s. The machine may be busy.
PATIENCE = 2.0


class Room:
    """The room in a page."""

    def __init__(self, browser: Browser, lab: Lab, size: dict = WIDE, scheme: str = "light", state: str = "recordings"):
        self.page = opened(browser, lab, f"#/{state}", size, scheme)

    def verdict(self) -> str:
        """The verdict, when no calculation is running."""
        self.page.wait_for_selector(".verdict[aria-busy=false]")
        return self.page.locator(".verdict").inner_text()

    def holds(self, what: str) -> None:
        sound(self.page, what)


def drag(page: Page, a: float, b: float) -> None:
    """Drags over the trend, from one share of the page's width to another."""
    box = page.locator(".over").bounding_box()
    y = box["y"] + 0.3 * box["height"]
    page.mouse.move(box["x"] + a * box["width"], y)
    page.mouse.down()
    for k in range(1, 9):
        page.mouse.move(box["x"] + (a + (b - a) * k / 8) * box["width"], y)
    page.mouse.up()


def judged(command: Path, path: Path) -> dict:
    """The JSON of the first loop that the command diagnoses."""
    said = subprocess.run([command, "diagnose", path, "--json"], check=True, capture_output=True, text=True, cwd=ROOT).stdout
    return json.loads(said)["loops"][0]


def samples(browser: Browser, command: Path, kept: Path) -> None:
    with running(command, *map(str, SAMPLES)) as lab:
        room = Room(browser, lab)
        page = room.page
        text = room.verdict()
        until(page, "document.querySelectorAll('.open li a').length === 5")
        assert "sticks" in text and "99" in text, text
        room.holds("a recording")

        # The verdict is for the selected stretch.
        began = time.monotonic()
        drag(page, 0.3, 0.7)
        until(page, "document.querySelector('.verdict h2').textContent.includes(': ')")
        stretch = room.verdict()
        took = time.monotonic() - began
        print(f"choosing a stretch, with the pointer's way: {took:.2f} s")
        assert took < PATIENCE and stretch != text
        page.wait_for_timeout(400)
        assert "from=" in page.url and "to=" in page.url, page.url

        # Keys move the stretch.
        end = page.get_by_role("slider", name="End of the stretch")
        before = float(end.get_attribute("aria-valuenow"))
        end.focus()
        for _ in range(5):
            page.keyboard.press("ArrowRight")
        assert float(end.get_attribute("aria-valuenow")) > before
        room.verdict()

        # Wheel, keys and buttons zoom, and the address contains the zoom.
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

        # A result is kept next to the following one.
        page.get_by_role("button", name="Keep to compare").click()
        page.get_by_role("button", name="Judge all").click()
        room.verdict()
        assert page.locator(".compare thead th").count() == 2
        room.holds("compared")
        page.evaluate("scrollTo(0, 0)")
        page.screenshot(path=kept / "lab-recordings-compared.png", full_page=True)

        # Every method has a figure, which is drawn on demand.
        page.locator(".more > summary").click()
        fold = page.locator(".fold", has_text="Every method")
        fold.locator("summary").first.click()
        fold.locator(".method > summary").first.click()
        fold.locator("img").first.wait_for()
        assert fold.locator("img").count() > 5
        room.holds("all details")
        page.screenshot(path=kept / "lab-recordings-details.png", full_page=True)

        # A link restores the same view.
        again = Room(browser, lab, state=held.split("#/")[1])
        again.verdict()
        assert again.page.locator(".handle.from").get_attribute("aria-valuenow") == page.evaluate(
            "url => new URLSearchParams(url.split('?')[1]).get('from')", held
        )
        again.page.close()

        # Each loop of the list.
        for each in SAMPLES[1:]:
            page.locator(".open li a", has_text=each.stem).click()
            until(page, f"document.querySelector('.about h1')?.textContent.includes('{each.stem}')")
            text = room.verdict()
            said = judged(command, each)
            assert said["verdict"]["grade"] in text, (each, said["verdict"]["grade"], text)
            room.holds(each.stem)
        page.close()
        for name, size, scheme in LOOKS:
            shot = Room(browser, lab, size, scheme)
            shot.verdict()
            drag(shot.page, 0.35, 0.75)
            until(shot.page, "document.querySelector('.verdict h2').textContent.includes('samples') && location.hash.includes('from=')")
            shot.verdict()
            shot.page.mouse.move(5, 5)
            shot.page.wait_for_timeout(300)
            shot.holds(f"looked at{name}")
            shot.page.screenshot(path=kept / f"lab-recordings{name}.png", full_page=bool(name))
            shot.page.close()


def nothing_open(browser: Browser, command: Path, kept: Path) -> None:
    """Checks the first use: the help, an example, a dropped file, and the choice of its columns."""
    with running(command) as lab:
        room = Room(browser, lab)
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
        # The names of its columns are unclear, so the user chooses them.
        page.get_by_label("What c is").wait_for()
        room.holds("columns that are not known")
        page.screenshot(path=kept / "lab-recordings-columns.png")
        for column, role in zip("abc", rows[0][1:4]):
            page.get_by_label(f"What {column} is", exact=True).select_option(role)
        page.get_by_role("button", name="Apply these settings").click()
        assert "sticks" in room.verdict()
        room.holds("columns that were said")
        page.close()


def large(browser: Browser, command: Path) -> None:
    """Checks a million samples: time to the trend, zoom, and time for a stretch of 2,000 samples."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "FIC900.csv"
        rows = list(csv.reader(SAMPLES[0].open()))
        period = [",".join(row[1:]) for row in rows[1:]]
        with path.open("w") as file:
            file.write(",".join(rows[0]) + "\n")
            for k in range(1_000_000):
                file.write(f"{k},{period[k % len(period)]}\n")
        with running(command, str(path)) as lab:
            began = time.monotonic()
            room = Room(browser, lab)
            page = room.page
            page.locator(".canvases").wait_for()
            print(f"1,000,000 samples, {path.stat().st_size / 1e6:.0f} MB: trend after {time.monotonic() - began:.1f} s")
            room.verdict()
            print(f"verdict on all of them after {time.monotonic() - began:.1f} s")
            # From here on, zooming loads no data.
            asked: list[str] = []
            page.on("request", lambda request: asked.append(request.url))
            page.evaluate(FRAMES)
            page.locator(".over").hover()
            for _ in range(40):
                page.mouse.wheel(0, -120)
                page.wait_for_timeout(30)
            times = sorted(page.evaluate("window.times"))
            print(f"zooming: {len(times)} frames, median {times[len(times) // 2]:.1f} ms, longest {times[-1]:.0f} ms")
            assert not asked, asked
            question = {"file": str(path), "loop": "FIC900", "from": 400_000, "to": 402_000}
            took = page.evaluate(
                """async question => { const took = []; for (let k = 0; k < 5; k++) { const began = performance.now();
                    const body = JSON.stringify({...question, from: question.from + k, to: question.to + k});
                    await (await fetch('/api/recordings/diagnose', {method: 'POST', body,
                        headers: {authorization: `Bearer ${sessionStorage.token}`}})).json();
                    took.push(performance.now() - began); } return took; }""",
                question,
            )
            print(f"verdict on a stretch of 2,000: {min(took):.0f} to {max(took):.0f} ms")
            assert not page.faults, page.faults


def written(browser: Browser, command: Path) -> None:
    """Checks the written files: an override and a mapping next to the recording."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        path = folder / SAMPLES[0].name
        shutil.copy(SAMPLES[0], path)
        with running(command, str(folder)) as lab:
            room = Room(browser, lab)
            page = room.page
            room.verdict()
            page.locator(".override > summary").click()
            page.get_by_label("The valve").select_option("does not stick")
            page.get_by_label("Because", exact=True).fill("new packing, stroked on the bench")
            page.get_by_label("Entered by").fill("J. Miller")
            page.get_by_role("button", name="Keep the override").click()
            page.get_by_text("Overruled by J. Miller").wait_for()
            page.get_by_role("button", name="Remove the override").wait_for()
            room.holds("overruled")
            page.locator(".columns > summary").click()
            page.get_by_label("Controls").select_option("level")
            page.get_by_role("button", name="Save as mapping file").click()
            # The message stays after the next reading, and the choice of columns stays open.
            room.verdict()
            page.locator(".columns").get_by_text("kept in").wait_for()
            assert 'type = "level"' in (folder / f"{path.name}.mapping.toml").read_text()
            page.get_by_role("button", name="Reset the columns").click()
            page.get_by_text("not saved yet").wait_for()
            page.get_by_role("button", name="Save as mapping file").click()
            page.get_by_text("The lab removed the file").wait_for()
            with page.expect_download() as saved:
                page.get_by_role("button", name="Save the report").click()
            assert "<svg" in Path(saved.value.path()).read_text()
            assert not page.faults, page.faults
        assert "J. Miller" in (folder / "stiction-overrides.toml").read_text()
        assert not (folder / f"{path.name}.mapping.toml").exists()
        assert path.read_bytes() == SAMPLES[0].read_bytes()


def main() -> None:
    command = Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        kept = Path(sys.argv[2]) if len(sys.argv) > 2 else Path(folder)
        kept.mkdir(parents=True, exist_ok=True)
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        samples(browser, command, kept)
        nothing_open(browser, command, kept)
        large(browser, command)
        written(browser, command)
        browser.close()
    print("the room of recordings holds")


if __name__ == "__main__":
    main()
