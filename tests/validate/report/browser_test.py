#!/usr/bin/python3
"""The report in a real browser, at desktop and phone width: no console error, no request, nothing wider than the window.

    browser_test.py SCREENSHOT_FOLDER REPORT_HTML

Leaves desktop.png, phone.png (whole pages) and first screens in the folder; exit
code 77, a skipped test, where there is no browser.
"""
import os
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
from browser import BROWSERS, SKIPPED, Browser, complaints, find_browser

SIZES = {"desktop": (1280, 800), "phone": (390, 844)}
# the boxes that stick out, so that a failure names them; what scrolls inside its own box may
STICKING_OUT = """[...document.querySelectorAll('body *')].filter(e => e.getBoundingClientRect().right > innerWidth + 0.5
  && !e.closest('.scroll, .wide, svg')).slice(0, 5).map(e => e.tagName + '.' + e.className + ': ' + e.textContent.slice(0, 60))"""

def check(browser, name, url, folder):
    width, height = SIZES[name]
    browser.events.clear()
    browser.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
    browser.open(url)
    failures = [f"{name}: {text}" for text in complaints(browser.events, lambda asked: asked == url or asked.startswith("data:"))]
    browser.picture(os.path.join(folder, f"{name}_first.png"), width, height)
    for opened in (False, True):
        browser.value(f"document.querySelectorAll('details').forEach(d => d.open = {str(opened).lower()})")
        scroll, inner = browser.value("document.documentElement.scrollWidth"), browser.value("innerWidth")
        out = browser.value(STICKING_OUT)
        if inner != width or scroll > inner or out:
            failures.append(f"{name}, details {'open' if opened else 'closed'}: {scroll} px wide in a window of {inner} px: {out}")
        browser.picture(os.path.join(folder, f"{name}{'_open' if opened else ''}.png"), width, browser.value("document.documentElement.scrollHeight"))
    return failures


def main():
    program = find_browser()
    if not program:
        print(f"skipped: none of {', '.join(BROWSERS)} is installed")
        return SKIPPED
    screenshots, page = sys.argv[1:]
    os.makedirs(screenshots, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        browser = Browser(program, os.path.join(folder, "profile"), ["--disable-gpu"])
        try:
            failures = [text for name in SIZES for text in check(browser, name, "file://" + os.path.abspath(page), screenshots)]
        finally:
            browser.close()
    for text in failures:
        print("FAILED:", text)
    print(f"{len(SIZES)} widths, {len(failures)} failures; screenshots in {screenshots}")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
