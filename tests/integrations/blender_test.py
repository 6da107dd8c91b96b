#!/usr/bin/env python3
"""The add-on in Debian's Blender: installed from its zip, in the background and, where there is a screen for it, in a window (in_blender.py).

    blender_test.py nlg_blender.zip TOOLS

Exit code 77, a skipped test, where Blender is not installed.
"""
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from browser import SKIPPED
from tools import SECONDS

SCRIPT = Path(__file__).with_name("in_blender.py")
WINDOW = ["xvfb-run", "-a", "-s", "-screen 0 1280x800x24"]


def failures_of(folder, before, options, zip_file, tools):
    """Lines that say what did not hold in one run of Blender."""
    work = folder / "work"
    work.mkdir(parents=True)
    # Debian's Blender takes whichever python3 the PATH has for its own
    environment = {**os.environ, "PATH": "/usr/bin:/bin", "LIBGL_ALWAYS_SOFTWARE": "1", "BLENDER_USER_SCRIPTS": str(folder / "scripts"), "BLENDER_USER_CONFIG": str(folder / "config")}
    command = [*before, "blender", *options, "--factory-startup", "--python-exit-code", "1", "--python", SCRIPT, "--", zip_file, tools, work]
    process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True)
    try:
        output, _ = process.communicate(timeout=5 * SECONDS)
    except subprocess.TimeoutExpired:
        # xvfb-run would leave its screen and Blender behind
        os.killpg(process.pid, signal.SIGKILL)
        output, _ = process.communicate()
    lines = output.splitlines()
    print("\n".join(line for line in lines if line.startswith(("holds: ", "FAILED: "))))
    failures = [line for line in lines if line.startswith("FAILED: ")]
    if options and not any("no light reaches a room" in line for line in lines):
        failures.append("FAILED: a script hears what the bake notes")
    if process.returncode != 0 or "end" not in lines or "Traceback" in output:
        failures.append(f"Blender ended with {process.returncode}:\n" + "\n".join(lines[-30:]))
    return failures


def main(zip_file, tools):
    if shutil.which("blender", path="/usr/bin") is None:
        print("skipped: Blender is not installed (Debian: blender)")
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder:
        failures = failures_of(Path(folder, "background"), [], ["-b"], zip_file, tools)
        if shutil.which("xvfb-run"):
            failures += failures_of(Path(folder, "window"), WINDOW, [], zip_file, tools)
        else:
            print("not in a window: xvfb-run is not installed (Debian: xvfb, xauth)")
    print("\n".join(failures) or "all of it holds")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(*map(os.path.abspath, sys.argv[1:])))
