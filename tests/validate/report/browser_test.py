#!/usr/bin/python3
"""The report in a real browser, at desktop and phone width: no console error, no request, nothing wider than the window.

    browser_test.py [SCREENSHOT_FOLDER [REPORT_HTML]]

Without a page it draws one from made-up inputs. Leaves desktop.png, phone.png (whole pages) and first screens in the folder; exit
code 77, a skipped test, where there is no browser.
"""
import base64
import json
import os
import shutil
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
import made_up

SKIPPED = 77
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "headless_shell")
REPORT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..", "validate", "report", "report.py")
SIZES = {"desktop": (1280, 800), "phone": (390, 844)}
HIGHEST_PX = 16000  # a screenshot's limit


class Browser:
    """Headless Chromium through its debugging pipe: JSON messages, each closed by a zero byte."""

    def __init__(self, program, profile):
        to_browser, self.write_end = os.pipe()
        self.read_end, from_browser = os.pipe()

        def place_pipes():
            # the browser reads 3 and writes 4; copies first, for the ends may have just these numbers
            ends = [os.dup2(end, 200 + i) for i, end in enumerate((to_browser, from_browser))]
            os.dup2(ends[0], 3)
            os.dup2(ends[1], 4)

        self.process = subprocess.Popen([program, "--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe", f"--user-data-dir={profile}", "--hide-scrollbars",
                                         "--no-first-run", "about:blank"], preexec_fn=place_pipes, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_browser)
        os.close(from_browser)
        self.buffer, self.last, self.events, self.session = b"", 0, [], None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def receive(self):
        while b"\0" not in self.buffer:
            part = os.read(self.read_end, 1 << 16)
            if not part:
                sys.exit("the browser closed its pipe")
            self.buffer += part
        message, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(message)

    def call(self, method, **parameters):
        self.last += 1
        message = {"id": self.last, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.write_end, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.receive()
            if answer.get("id") == self.last:
                if "error" in answer:
                    sys.exit(f"{method}: {answer['error']['message']}")
                return answer["result"]
            self.events.append(answer)

    def open(self, url):
        self.call("Page.navigate", url=url)
        while not any(event.get("method") == "Page.loadEventFired" for event in self.events):
            self.events.append(self.receive())

    def value(self, expression):
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            sys.exit(f"{expression}: {result['exceptionDetails']['text']}")
        return result["result"].get("value")

    def picture(self, path, width, height):
        data = self.call("Page.captureScreenshot", captureBeyondViewport=True, clip={"x": 0, "y": 0, "width": width, "height": min(height, HIGHEST_PX), "scale": 1})["data"]
        with open(path, "wb") as file:
            file.write(base64.b64decode(data))

    def close(self):
        self.process.terminate()
        self.process.wait()


def complaints(events, url):
    """What the page said to the console, and what it asked for besides itself."""
    result = []
    for event in events:
        method, parameters = event.get("method"), event.get("params", {})
        if method == "Runtime.consoleAPICalled" and parameters["type"] in ("error", "warning", "assert"):
            result.append(f"console: {parameters['args']}")
        elif method == "Runtime.exceptionThrown":
            result.append(f"exception: {parameters['exceptionDetails'].get('exception', {}).get('description', parameters['exceptionDetails']['text'])}")
        elif method == "Log.entryAdded" and parameters["entry"]["level"] in ("error", "warning"):
            result.append(f"log: {parameters['entry']['text']}")
        elif method == "Network.requestWillBeSent" and parameters["request"]["url"] != url and not parameters["request"]["url"].startswith("data:"):
            result.append(f"asks for {parameters['request']['url']}")
    return result


# the boxes that stick out, so that a failure names them; what scrolls inside its own box may
STICKING_OUT = """[...document.querySelectorAll('body *')].filter(e => e.getBoundingClientRect().right > innerWidth + 0.5
  && !e.closest('.scroll, .wide, svg')).slice(0, 5).map(e => e.tagName + '.' + e.className + ': ' + e.textContent.slice(0, 60))"""
# what a box that scrolls sideways says of it: [scrolls, says so] of every plot
HINTS = """[...document.querySelectorAll('.wide')].map(e => [e.scrollWidth > e.clientWidth, !['none', 'normal', ''].includes(getComputedStyle(e, '::before').content)])"""
# pointing at a plot's point shows what it stands for
POINTED = """(() => { const point = document.querySelector('svg .tip'); if (!point) return 'no point';
  point.dispatchEvent(new PointerEvent('pointerover', {bubbles: true}));
  const tip = document.getElementById('tip'); const shown = tip.hidden ? '' : tip.textContent; tip.hidden = true; return shown; })()"""


def check(browser, name, url, folder):
    width, height = SIZES[name]
    browser.events.clear()
    browser.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
    browser.open(url)
    failures = [f"{name}: {text}" for text in complaints(browser.events, url)]
    browser.picture(os.path.join(folder, f"{name}_first.png"), width, height)
    for opened in (False, True):
        browser.value(f"document.querySelectorAll('details').forEach(d => d.open = {str(opened).lower()})")
        scroll, inner = browser.value("document.documentElement.scrollWidth"), browser.value("innerWidth")
        out = browser.value(STICKING_OUT)
        if inner != width or scroll > inner or out:
            failures.append(f"{name}, details {'open' if opened else 'closed'}: {scroll} px wide in a window of {inner} px: {out}")
        browser.picture(os.path.join(folder, f"{name}{'_open' if opened else ''}.png"), width, browser.value("document.documentElement.scrollHeight"))
    hints = browser.value(HINTS)
    if any(scrolls != says for scrolls, says in hints) or (name == "phone" and not any(scrolls for scrolls, _ in hints)):
        failures.append(f"{name}: plots that scroll sideways, and whether they say so: {hints}")
    headline = browser.value("(() => { const box = document.querySelector('.cards').getBoundingClientRect(); return box.bottom + scrollY; })()")
    if name == "desktop" and headline > height:
        failures.append(f"{name}: the three figures end at {headline:.0f} px, below the first screen of {height} px")
    if browser.value("!!document.querySelector('#frontier')") and "RMSE" not in browser.value(POINTED):
        failures.append(f"{name}: pointing at a plot's point shows '{browser.value(POINTED)}'")
    return failures


def main():
    program = next(filter(None, map(shutil.which, BROWSERS)), None)
    if not program:
        print(f"skipped: none of {', '.join(BROWSERS)} is installed")
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder:
        screenshots = sys.argv[1] if len(sys.argv) > 1 else folder
        os.makedirs(screenshots, exist_ok=True)
        page = sys.argv[2] if len(sys.argv) > 2 else os.path.join(folder, "report.html")
        if len(sys.argv) <= 2:
            needed, proof = made_up.write_all(folder)
            subprocess.run(["/usr/bin/python3", REPORT, *needed, *proof, "--out", page], check=True)
        browser = Browser(program, os.path.join(folder, "profile"))
        try:
            failures = [text for name in SIZES for text in check(browser, name, "file://" + os.path.abspath(page), screenshots)]
        finally:
            browser.close()
    for text in failures:
        print("FAILED:", text)
    print(f"{len(SIZES)} widths, {len(failures)} failures; screenshots in {screenshots}" if len(sys.argv) > 1 else f"{len(SIZES)} widths, {len(failures)} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
