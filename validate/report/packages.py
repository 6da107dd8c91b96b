"""The Python packages that the report's tools draw with: asked for before anything imports one."""
import importlib.util
import sys

USAGE_ERROR = 2  # tool/error.h


def need(tool, *names):
    """Ends the tool with one line where this Python lacks one of them, as another Python first in PATH does."""
    missing = [name for name in names if importlib.util.find_spec(name) is None]
    if missing:
        print(f"{tool}: error: {sys.executable}: packages: expected a Python with {', '.join(names)}, such as Debian's /usr/bin/python3, got one without {', '.join(missing)}",
              file=sys.stderr)
        sys.exit(USAGE_ERROR)
