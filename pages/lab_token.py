"""Checks in a real browser that only the lab's own page gets its token, and no other port of the machine.

python3 pages/lab_token.py COMMAND
"""

import contextlib
import sqlite3
import sys
import tempfile
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from lab import CHROMIUM, ROOT, Lab, running
from playwright.sync_api import BrowserContext, Page, expect, sync_playwright

SAMPLE = ROOT / "samples/FIC101-sticky.csv"
#: The attempts of a page from another port: to send requests to the lab, load its script, frame it, and open it.
TRIES = """async origin => {
    const tried = {};
    const asks = {
        post: () => fetch(origin + "/api/recordings", {method: "POST", body: "{}", credentials: "include"}),
        blind: () => fetch(origin + "/api/recordings", {method: "POST", body: "{}", credentials: "include", mode: "no-cors"}),
        header: () => fetch(origin + "/api/recordings", {method: "POST", body: "{}", headers: {authorization: "Bearer 0"}}),
        get: () => fetch(origin + "/api/recordings/trend?file=a&loop=b", {credentials: "include"}),
        page: () => fetch(origin + "/", {credentials: "include"}),
        script: () => new Promise((done, fail) => {
            const script = document.createElement("script");
            script.src = origin + "/lab.js"; script.onload = done; script.onerror = fail;
            document.head.append(script);
        }),
    };
    for (const [name, ask] of Object.entries(asks)) {
        try { const answer = await ask(); tried[name] = answer?.type === "opaque" ? "blind" : "answered"; }
        catch { tried[name] = "refused"; }
    }
    tried.stored = JSON.stringify({...sessionStorage, ...localStorage}) + document.cookie;
    const channel = new BroadcastChannel("token");
    tried.told = await Promise.race([
        new Promise(done => { channel.onmessage = event => done(JSON.stringify(event.data)); channel.postMessage({}); }),
        new Promise(done => setTimeout(() => done("nothing"), 500)),
    ]);
    return tried;
}"""


@contextlib.contextmanager
def other_port() -> Iterator[tuple[str, list[str]]]:
    """A server on another loopback port, with all requests that it receives."""
    received: list[str] = []

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            received.append(f"{self.requestline}\n{self.headers}")
            self.send_response(200)
            self.send_header("content-type", "text/html")
            self.end_headers()
            self.wfile.write(b"<!doctype html><title>other</title><body>other")

        def log_message(self, *_: object) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}", received
    server.shutdown()


def is_open(page: Page) -> None:
    """Checks that the room shows data of the lab."""
    expect(page.locator(".recordings .verdict .badge").first).to_contain_text("sticks", timeout=30_000)


def own_page(context: BrowserContext, lab: Lab, token: str) -> Page:
    """Checks that the printed address, a reload, a second tab with this address and a link open the lab."""
    page = context.new_page()
    asked: list[str] = []
    context.on("request", lambda request: asked.append(request.url))
    page.goto(f"{lab.address}/recordings")
    is_open(page)
    assert token not in page.url, page.url
    page.reload()
    is_open(page)
    for address in (f"{lab.address}/recordings", f"{lab.origin}/#/recordings"):
        second = context.new_page()
        second.goto(address)
        is_open(second)
        assert token not in second.url, second.url
        second.close()
    assert context.cookies() == [], context.cookies()
    # The report opens in its own tab, without access to the token.
    with context.expect_page() as opened:
        page.get_by_role("button", name="Open the report").click()
    report = opened.value
    expect(report).to_have_title("Diagnosis of FIC101-sticky", timeout=30_000)
    assert report.evaluate("self.origin") == "null" and report.evaluate("opener") is None
    report.reload()
    expect(report).to_have_title("Diagnosis of FIC101-sticky")
    report.close()
    with page.expect_download() as saved:
        page.get_by_role("button", name="Save the report").click()
    assert saved.value.suggested_filename == "FIC101-sticky.html"
    assert "Diagnosis of" in Path(saved.value.path()).read_text()
    assert not any(token in url.split("#")[0] for url in asked), "the token was in a request's address"
    return page


def elsewhere(context: BrowserContext, lab: Lab, token: str) -> None:
    """Checks that a page from another port gets no token, no response and no data."""
    with other_port() as (other, received):
        page = context.new_page()
        page.goto(f"{other}/steal")
        tried = page.evaluate(TRIES, lab.origin)
        # This request is sent, but the lab refuses it. The browser blocks all others.
        assert tried.pop("blind") in ("blind", "refused")
        assert tried == {
            **dict.fromkeys(("post", "header", "get", "page", "script"), "refused"),
            "stored": "{}",
            "told": "nothing",
        }, tried
        # A page that the lab's tab visits and leaves.
        own = context.new_page()
        own.goto(f"{lab.address}/recordings")
        is_open(own)
        own.goto(f"{other}/next")
        assert own.evaluate("JSON.stringify({...sessionStorage})") == "{}"
        own.go_back()
        is_open(own)
        assert received and not any(token in each or "ookie:" in each for each in received), received
        own.close()
        page.close()


def without(context: BrowserContext, lab: Lab) -> None:
    """Checks that a page without the token asks for it, and accepts the printed address."""
    page = context.new_page()
    page.goto(f"{lab.origin}/#/recordings")
    expect(page.get_by_text("This page needs the address of the lab")).to_be_visible()
    page.get_by_label("Address").fill("nonsense")
    page.get_by_role("button", name="Open the lab").click()
    expect(page.get_by_role("alert")).to_be_visible()
    page.get_by_label("Address").fill(lab.address)
    page.get_by_role("button", name="Open the lab").click()
    is_open(page)


def main() -> None:
    command = Path(sys.argv[1]).resolve()
    with sync_playwright() as playwright, running(command, "--port", "0", str(SAMPLE)) as lab:
        token = lab.address.rsplit("=", 1)[1]
        with tempfile.TemporaryDirectory() as profile:
            context = playwright.chromium.launch_persistent_context(
                profile, executable_path=CHROMIUM, args=["--no-sandbox"]
            )
            page = own_page(context, lab, token)
            elsewhere(context, lab, token)
            page.close()
            context.close()
            history = sqlite3.connect(Path(profile) / "Default" / "History")
            kept = [url for (url,) in history.execute("select url from urls") if token in url]
            print(f"of the browser's history {len(kept)} addresses have the token")
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        without(browser.new_context(), lab)
        browser.close()
    print("the lab's token stays with the lab's page")


if __name__ == "__main__":
    main()
