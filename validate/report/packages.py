"""The Python packages that the report's tools draw with: asked for before anything imports one."""
import importlib.util
import os
import sys

# the root, for tool/, which all scripts share
sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))

from tool.errors import USAGE_ERROR, say


def need(tool, *names):
    """Ends the tool with one line where this Python lacks one of them, as another Python first in PATH does."""
    missing = [name for name in names if importlib.util.find_spec(name) is None]
    if missing:
        say(tool, f"{sys.executable}: packages: expected a Python with {', '.join(names)}, such as Debian's /usr/bin/python3, got one without {', '.join(missing)}")
        sys.exit(USAGE_ERROR)
