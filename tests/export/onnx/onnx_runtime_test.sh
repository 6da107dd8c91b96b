#!/usr/bin/env bash
# Exported generators in a runtime that is not ours: ONNX models against the evaluator, over some hundred functions.
#
#   onnx_runtime_test.sh BUILD_FOLDER ONNX_CASES
#
# Exit code 77, a skipped test, without onnxruntime (workflow/install_from_npm.sh).
set -euo pipefail
build=$1 onnx_cases=$2
source=$(cd "$(dirname "$0")/../../.." && pwd)
runtime=$(dirname "$build")/onnxruntime count=300
if [ ! -d "$runtime/node_modules/onnxruntime-node" ] || ! command -v node > /dev/null; then
  echo "SKIPPED: onnxruntime is not installed; workflow/install_from_npm.sh onnxruntime $runtime says why not"
  exit 77
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "onnx_runtime_test: $*" >&2; exit 1; }

shopt -s nullglob
"$onnx_cases" "$work" "$count" "$source"/weights/*.safetensors
for weights in "$work"/*.safetensors; do
  "$build/bin/nlg-export" onnx --weights "$weights" --out "${weights%.safetensors}.onnx"
done
node "$source/tests/export/onnx/run_onnx.js" "$runtime" "$work" "$count"

# what is no chain of layers is refused, and nothing is left behind
status=0
"$build/bin/nlg-export" onnx --weights "$work/float16.onnx" --out "$work/wrong.onnx" 2> "$work/stderr" || status=$?
[ "$status" -eq 3 ] && [ ! -e "$work/wrong.onnx" ] || fail "a file that is no weights file gives exit code $status"
