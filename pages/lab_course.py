"""Checks the room of the course: every lesson with right and wrong answers, the sheet, the table of a class, in Chromium.

    python pages/lab_course.py target/debug/stiction [folder for the pictures]

Needs `pip install playwright` and Chromium.
"""

import re
import sys
import tempfile
from pathlib import Path

from lab import CHROMIUM, LOOKS, PHONE, WIDE, Lab, opened, running, sound
from playwright.sync_api import Browser, Page, expect, sync_playwright

CLASS = 12
NAMES = ["Ada Lovelace", "Zoë Müller"]


def at(page: Page) -> None:
    """Waits until the lesson is there."""
    expect(page.locator(".questions li").first).to_be_visible(timeout=60_000)


def answers(browser: Browser, lab: Lab) -> list[list[str]]:
    """The answers to all lessons, as the teacher gets them."""
    page = opened(browser, lab, f"#/course?view=class&class={CLASS}")
    page.get_by_text("Answers, for the teacher").click()
    page.get_by_role("button", name="Show the answers").click()
    expect(page.locator("details section")).to_have_count(6, timeout=60_000)
    found = [each.locator("li").all_inner_texts() for each in page.locator("details section").all()]
    sound(page, "the answers")
    page.close()
    return found


def enter(page: Page, given: list[str], wrong: int | None = None) -> None:
    """Enters answers. One answer is wrong if requested."""
    for k, (question, answer) in enumerate(zip(page.locator(".questions li").all(), given, strict=True)):
        if question.locator("fieldset").count():
            choice = question.get_by_label(answer, exact=True)
            if k == wrong:
                others = [each for each in question.get_by_role("radio").all() if each.evaluate("e => e.parentElement.innerText").strip() != answer]
                choice = others[0]
            choice.check()
        else:
            value = float(answer.split(" ", 1)[0])
            # With a decimal comma, as many type it.
            question.locator("input").fill(f"{2 * value + 1 if k == wrong else value:.2f}".replace(".", ","))


def lessons(browser: Browser, lab: Lab, kept: Path) -> list[str]:
    """All lessons by one student: first with a wrong answer, then with all right. The lines for the teacher."""
    right = answers(browser, lab)
    lines = []
    page = opened(browser, lab, f"#/course?class={CLASS}")
    for k, given in enumerate(right):
        at(page)
        expect(page.locator("article h1")).to_contain_text(f"Lesson {k + 1}")
        check = page.get_by_role("button", name="Check")
        if k == 0:
            # Without a name there is no code.
            check.click()
            expect(page.get_by_role("alert")).to_contain_text("enter a name")
            page.get_by_label("Your name").fill(NAMES[0])
        # Nothing was entered: no answer is right, and there is a code for that, too.
        check.click()
        expect(page.get_by_text(f"0 of {len(given)} answers are right")).to_be_visible(timeout=60_000)
        enter(page, given, wrong=k % len(given))
        check.click()
        expect(page.get_by_text(f"{len(given) - 1} of {len(given)} answers are right")).to_be_visible(timeout=60_000)
        expect(page.locator(".questions li strong.wrong")).to_have_count(1)
        expect(page.locator(".questions li").nth(k % len(given)).locator("strong")).to_contain_text("wrong")
        sound(page, f"lesson {k + 1}, one wrong", ["400"])
        enter(page, given)
        check.click()
        expect(page.get_by_text(f"All {len(given)} answers are right")).to_be_visible(timeout=60_000)
        page.get_by_role("button", name="Copy the line").click()
        expect(page.get_by_text("Copied.")).to_be_visible()
        lines.append(page.evaluate("navigator.clipboard.readText()"))
        assert re.fullmatch(rf"{NAMES[0]}, [0-9A-Z]{{5}}-[0-9A-Z]{{5}}", lines[-1]), lines
        page.screenshot(path=kept / f"lab-course-{k + 1}-done.png", full_page=True)
        sound(page, f"lesson {k + 1}", ["400"])
        room = page.get_by_role("link", name="Open the room of the task")
        if room.count():
            with page.context.expect_page() as other:
                room.click()
            expect(other.value.locator(".valve .label, .hand").first).to_be_visible(timeout=30_000)
            assert other.value.locator("[role=alert]").count() == 0
            other.value.close()
        if k + 1 < len(right):
            page.get_by_role("link", name="Next lesson").click()
    # Another student, by the link.
    page.get_by_role("link", name="1. What stiction does").click()
    at(page)
    page.get_by_label("Your name").fill(NAMES[1])
    enter(page, right[0], wrong=2)
    page.get_by_role("button", name="Check").click()
    lines.append(page.locator("code.line").inner_text(timeout=60_000))
    page.close()
    print("codes:", lines[0], "|", lines[-1])
    return lines


def table(browser: Browser, lab: Lab, lines: list[str], kept: Path) -> None:
    """The table of a class: good lines, lines with typos, and the file."""
    typo = lines[1][:-1] + ("0" if lines[1][-1] != "0" else "1")
    page = opened(browser, lab, f"#/course?view=class&class={CLASS}")
    page.get_by_label("Lines").fill("\n".join([*lines, typo, "nobody"]))
    page.get_by_role("button", name="Make the table").click()
    rows = page.locator(".rows tbody tr")
    expect(rows).to_have_count(len(lines))
    expect(rows.first).to_contain_text("3 of 3")
    expect(rows.last).to_contain_text(NAMES[1])
    expect(rows.last).to_contain_text("2 of 3")
    expect(rows.last).to_contain_text("✓ ✓ ✗")
    expect(page.get_by_text("2 lines were refused")).to_be_visible()
    expect(page.get_by_text(f"Line {len(lines) + 1}: code and name do not match")).to_be_visible()
    with page.expect_download() as download:
        page.get_by_role("button", name="Save as CSV").click()
    saved = Path(download.value.path()).read_text("utf-8-sig").splitlines()
    assert len(saved) == len(lines) + 1 and saved[0].startswith('"Student","Lesson"'), saved
    sound(page, "the table")
    for suffix, size in (("", WIDE), ("-phone", PHONE)):
        page.set_viewport_size(size)
        page.screenshot(path=kept / f"lab-course-class{suffix}.png", full_page=True)
        sound(page, f"the table{suffix}")
    # Nothing was kept in the browser but the token.
    kept_keys = page.evaluate("[...Object.keys(localStorage), ...Object.keys(sessionStorage)]")
    assert kept_keys == ["token"], kept_keys
    page.close()


def sheets(browser: Browser, lab: Lab, kept: Path) -> None:
    """The sheets on A4, without answers, in either theme."""
    for k in range(1, 7):
        page = opened(browser, lab, f"#/course?lesson={k}&class={CLASS}", scheme="dark" if k % 2 else "light")
        at(page)
        page.wait_for_timeout(300)
        pdf = page.pdf(path=kept / f"sheet-{k}.pdf", prefer_css_page_size=True)
        pages = len(re.findall(rb"/Type\s*/Page\b", pdf))
        assert re.search(rb"/MediaBox\s*\[0 0 59[4-6]\S* 84[1-2]", pdf), "not A4"
        assert 1 <= pages <= 2, f"the sheet of lesson {k} has {pages} pages"
        # Nor with answers that were checked before.
        page.get_by_label("Your name").fill(NAMES[0])
        page.get_by_role("button", name="Check").click()
        expect(page.locator("code.line")).to_be_visible(timeout=60_000)
        page.emulate_media(media="print")
        for hidden in (".questions strong", "code.line", ".trends", "header.top"):
            expect(page.locator(hidden).first).to_be_hidden()
        page.set_viewport_size({"width": 680, "height": 1000})
        page.screenshot(path=kept / f"sheet-{k}.png", full_page=True)
        page.close()


def looks(browser: Browser, lab: Lab, kept: Path) -> None:
    views = [*LOOKS, ("-dark", WIDE, "dark"), ("-phone-dark", PHONE, "dark")]
    for k in range(1, 7):
        for suffix, size, scheme in views:
            page = opened(browser, lab, f"#/course?lesson={k}&class={CLASS}", size, scheme)
            at(page)
            page.wait_for_timeout(300)
            sound(page, f"lesson {k}{suffix}")
            page.screenshot(path=kept / f"lab-course-{k}{suffix}.png", full_page=True)
            page.close()


def main() -> None:
    command = Path(sys.argv[1]).resolve()
    with sync_playwright() as playwright, running(command) as lab, tempfile.TemporaryDirectory() as other:
        kept = Path(sys.argv[2] if len(sys.argv) > 2 else other)
        kept.mkdir(parents=True, exist_ok=True)
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        lines = lessons(browser, lab, kept)
        table(browser, lab, lines, kept)
        sheets(browser, lab, kept)
        looks(browser, lab, kept)
        browser.close()


if __name__ == "__main__":
    main()
