"""A real browser for tests of pages: Chromium, headless."""
import base64
import glob
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "headless_shell")
SKIPPED = 77  # ctest's exit code of a test that lacks what it needs
# what SwiftShader says of the browser's own reading back, on a machine without a graphics card
OF_THE_BROWSER = "GPU stall due to ReadPixels"
HIGHEST_PX = 16000  # a screenshot's limit
LONGEST_CLOSE_S = 60


def find_browser():
    """The path of the first that is installed, or None."""
    return next(filter(None, map(shutil.which, BROWSERS)), None)


def complaints(events, is_own=lambda url: True):
    """What the page said to the console, and what it asked for that is not its own."""
    result = []
    for event in events:
        method, parameters = event.get("method"), event.get("params", {})
        if method == "Runtime.consoleAPICalled" and parameters["type"] in ("error", "warning", "assert"):
            result.append(f"console: {parameters['args']}")
        elif method == "Runtime.exceptionThrown":
            result.append(f"exception: {parameters['exceptionDetails'].get('exception', {}).get('description', parameters['exceptionDetails']['text'])}")
        elif method == "Log.entryAdded" and parameters["entry"]["level"] in ("error", "warning") and OF_THE_BROWSER not in parameters["entry"]["text"]:
            result.append(f"log: {parameters['entry']['text']}")
        elif method == "Network.requestWillBeSent" and not is_own(parameters["request"]["url"]):
            result.append(f"asks for {parameters['request']['url']}")
    return result


def is_running(group):
    """Whether any process of the group runs still; one that nobody has waited for does not."""
    for path in glob.glob("/proc/[0-9]*/stat"):
        try:
            with open(path, encoding="utf-8", errors="replace") as file:
                state, _, its_group = file.read().rpartition(")")[2].split()[:3]
        except (FileNotFoundError, ProcessLookupError):
            continue  # it ended meanwhile
        if int(its_group) == group and state not in "ZX":
            return True
    return False


class Browser:
    """Headless Chromium through its debugging pipe: JSON messages, each closed by a zero byte."""

    def __init__(self, program, profile, options):
        to_browser, self.write_end = os.pipe()
        self.read_end, from_browser = os.pipe()

        def place_pipes():
            # the browser reads 3 and writes 4; copies first, for the ends may have just these numbers
            ends = [os.dup2(end, 200 + i) for i, end in enumerate((to_browser, from_browser))]
            os.dup2(ends[0], 3)
            os.dup2(ends[1], 4)

        self.said = tempfile.TemporaryFile()
        # a session of its own: the processes that draw and fetch outlive the first one and write in the profile, so close ends the group
        self.process = subprocess.Popen([program, "--headless", "--no-sandbox", "--remote-debugging-pipe", f"--user-data-dir={profile}", "--hide-scrollbars",
                                         "--no-first-run", *options, "about:blank"], preexec_fn=place_pipes, close_fds=False, start_new_session=True, stdout=subprocess.DEVNULL, stderr=self.said)
        os.close(to_browser)
        os.close(from_browser)
        self.buffer, self.last, self.events, self.session = b"", 0, [], None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self.call("Page.setLifecycleEventsEnabled", enabled=True)

    def receive(self):
        while b"\0" not in self.buffer:
            part = os.read(self.read_end, 1 << 16)
            if not part:
                self.said.seek(0)
                sys.exit("the browser closed its pipe; the last that it said:\n" + self.said.read().decode(errors="replace")[-2000:])
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
        """Goes there and waits until that page has loaded: on a busy machine the page before may report its own load meanwhile."""
        loader = self.call("Page.navigate", url=url)["loaderId"]
        loaded = {"loaderId": loader, "name": "load"}
        while not any(event.get("method") == "Page.lifecycleEvent" and loaded.items() <= event["params"].items() for event in self.events):
            self.events.append(self.receive())

    def value(self, expression):
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            said = result["exceptionDetails"]
            sys.exit(f"{expression}: {said.get('exception', {}).get('description', said['text'])}")
        return result["result"].get("value")

    def picture(self, path, width, height):
        data = self.call("Page.captureScreenshot", captureBeyondViewport=True, clip={"x": 0, "y": 0, "width": width, "height": min(height, HIGHEST_PX), "scale": 1})["data"]
        with open(path, "wb") as file:
            file.write(base64.b64decode(data))

    def close(self):
        """Ends every process of the browser, so that its profile can be deleted."""
        try:
            os.killpg(self.process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        self.process.wait()
        deadline = time.monotonic() + LONGEST_CLOSE_S
        while is_running(self.process.pid):
            if time.monotonic() > deadline:
                sys.exit(f"processes of the browser run on {LONGEST_CLOSE_S} s after they were killed")
            time.sleep(0.01)
        for end in (self.read_end, self.write_end):
            os.close(end)
        self.said.close()
