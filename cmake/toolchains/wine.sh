#!/bin/sh
# Runs a program for Windows: what wine keeps lies in the build, and it says nothing of itself.
export WINEPREFIX="${WINEPREFIX:-$(dirname "$0")/../../build/wine}" WINEDEBUG="${WINEDEBUG:--all}"
mkdir -p "$WINEPREFIX" && WINEPREFIX=$(cd "$WINEPREFIX" && pwd)
exec "$(command -v wine64 || echo /usr/lib/wine/wine64)" "$@"
