"""Shared by the checks of the lab's rooms: a running lab, and a page that may load only from it."""

import contextlib
import os
import re
import subprocess
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

from playwright.sync_api import Browser, BrowserContext, Page

ROOT = Path(__file__).resolve().parent.parent
CHROMIUM = "/usr/bin/chromium"
AXE = ROOT / "addons/stiction-lab/web/node_modules/axe-core/axe.min.js"
WIDE = {"width": 1300, "height": 1000}
PHONE = {"width": 390, "height": 844}
PROJECTOR = {"width": 1920, "height": 1080}
#: The views of a room: name of the screenshot, size, light or dark.
LOOKS = [("", WIDE, "light"), ("-phone", PHONE, "light"), ("-projector", PROJECTOR, "dark")]


#: Records the time of each following frame in `window.times`, ms.
FRAMES = """() => { window.times = []; let last = performance.now();
    const step = now => { window.times.push(now - last); last = now; requestAnimationFrame(step); };
    requestAnimationFrame(step); }"""


class Lab:
    """A running lab, with its printed address."""

    def __init__(self, process: "subprocess.Popen[str]", address: str) -> None:
        self.process, self.address = process, address
        self.origin = address.split("/#", 1)[0]

    def cpu_s(self) -> float:
        """CPU time so far, s."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def peak_mb(self) -> float:
        """Peak memory, MB."""
        found = re.search(r"VmHWM:\s+(\d+) kB", Path(f"/proc/{self.process.pid}/status").read_text())
        return int(found[1]) / 1000 if found else float("nan")


@contextlib.contextmanager
def running(command: Path, *arguments: str) -> Iterator[Lab]:
    """A running lab. It prints its address in the first line."""
    process = subprocess.Popen(
        [command, "--quiet", "lab", "--no-open", *arguments], stdout=subprocess.PIPE, text=True, cwd=ROOT
    )
    try:
        assert process.stdout
        yield Lab(process, process.stdout.readline().strip())
    finally:
        process.terminate()
        process.wait()


def opened(browser: Browser, lab: Lab, at: str, size: dict[str, int] = WIDE, scheme: str = "light") -> Page:
    """A page of the lab. A script error, or a request to another server, ends the check."""
    context: BrowserContext = browser.new_context(viewport=size, color_scheme=scheme, accept_downloads=True)
    context.grant_permissions(["clipboard-read", "clipboard-write"], origin=lab.origin)
    page = context.new_page()
    page.faults = []  # type: ignore[attr-defined]
    page.on("pageerror", lambda error: page.faults.append(str(error)))
    page.on("console", lambda message: message.type == "error" and page.faults.append(message.text))
    page.on("request", lambda request: request.url.startswith((lab.origin, "data:", "blob:")) or page.faults.append(request.url))
    # The printed address, with the room after the token.
    page.goto(lab.address + at.removeprefix("#"))
    return page


def until(page: Page, what: str, seconds: float = 20) -> None:
    """Waits until an expression on the page is true, because the lab's policy forbids Playwright's own method."""
    end = time.monotonic() + seconds
    while not page.evaluate(what):
        assert time.monotonic() < end, f"never true: {what}"
        page.wait_for_timeout(50)


def sound(page: Page, what: str, faults: Sequence[str] = ()) -> None:
    """Checks for unexpected errors, content wider than the screen, and faults of accessibility."""
    unexpected = [each for each in page.faults if not any(known in each for known in faults)]  # type: ignore[attr-defined]
    assert not unexpected, f"{what}: {unexpected}"
    wide = page.evaluate("document.documentElement.scrollWidth - innerWidth")
    assert wide <= 0, f"{what}: {wide} px beside the screen"
    page.evaluate(AXE.read_text())
    found = page.evaluate("axe.run(document, {resultTypes: ['violations']})")
    serious = [
        f"{each['id']}: {each['help']} ({each['nodes'][0]['html'][:120]}; {each['nodes'][0]['failureSummary'][:300]})"
        for each in found["violations"]
        if each["impact"] in ("serious", "critical")
    ]
    assert not serious, f"{what}: {serious}"
