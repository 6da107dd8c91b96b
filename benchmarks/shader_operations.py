#!/usr/bin/python3
"""What one pixel of look_up.glsl costs at most, for each kind of grid: counted in its SPIR-V, all loops unrolled, all eight probes lit.

    shader_operations.py        prints the table of docs/reference/engines.md

Needs glslangValidator, spirv-opt and spirv-dis (Debian: glslang-tools, spirv-tools). Operations are on single numbers: a product of four is
four. Whatever moves or renames numbers, labels and branches do not count; a function of GLSL (exp, min, max, unpackHalf2x16) is one.
"""
import collections
import os
import re
import subprocess
import sys
import tempfile

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
GRIDS = {"bare tents alone": ["NLG_CLASS_COUNT=2"],
         "`tent_mlp4`": ["NLG_CLASS_COUNT=3", "NLG_NETWORK_4"],
         "`tent_mlp44`": ["NLG_CLASS_COUNT=3", "NLG_NETWORK_44"],
         "`tent_mlp`, `mlp`": ["NLG_CLASS_COUNT=3", "NLG_NETWORK_88"],
         "product fields": ["NLG_CLASS_COUNT=3", "NLG_FIELD"],
         "codes": ["NLG_CLASS_COUNT=3", "NLG_BRICK"]}
# of kaos2: 22 numbers of 3 to 8 bits
WIDTHS = [[8, 8, 7], [8, 8, 6, 6, 4], [6, 6, 6, 6, 6, 2], [6, 6, 5, 3, 3, 3, 3, 3]]
FIELDS = [word | (9 * (word == 0) + sum(widths[:i])) << 3 | width << 8 for word, widths in enumerate(WIDTHS) for i, width in enumerate(widths)]
LIGHT = [f"NLG_LIGHT_AXES={len(FIELDS)}", "NLG_LIGHT_WORDS=4", "NLG_LIGHT_FIELDS=uint[](" + ",".join(f"{field}u" for field in FIELDS) + ")"]
# the head is a uniform: the same for all pixels
HEAD = """#version 450
#extension GL_EXT_control_flow_attributes : require
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Words { uint words[]; };
layout(std430, binding = 0) readonly buffer Fours { uvec4 fours[]; };
layout(std430, binding = 1) readonly buffer Places { vec4 places[]; };
layout(std430, binding = 2) writeonly buffer Lights { vec4 lights[]; };
layout(std140, binding = 3) uniform Head { uvec4 head[256]; };
uvec4 nlgHeader(int i) { return head[i]; }
uvec4 nlgFour(int i) { return fours[i]; }
uint nlgWord(int i) { return words[i]; }
"""
WHOLE = """
void main() {
  uint i = gl_GlobalInvocationID.x;
  NlgLight light = nlgIrradiance(places[2u * i].xyz, places[2u * i + 1u].xyz);
  lights[i] = vec4(light.irradiance, float(light.status));
}"""
# from a position to the records of its eight probes and its place in their supports
TRAVERSAL = """
void main() {
  uint i = gl_GlobalInvocationID.x;
  vec4 frame = uintBitsToFloat(nlgHeader(0));
  NlgCell cell = nlgFindCell((places[2u * i].xyz - frame.xyz) * frame.w);
  if (!cell.found) return;
  [[unroll]] for (int c = 0; c < 8; ++c) {
    NlgCorner corner = nlgCornerOf(cell, c);
    lights[8u * i + uint(c)] = vec4(corner.local, corner.tent * corner.ratio) + float(corner.record);
  }
}"""
PASSES = ["--merge-return", "--inline-entry-points-exhaustive", "--eliminate-dead-functions", "--scalar-replacement=0", "--ssa-rewrite", "--ccp",
          *["--loop-unroll", "--merge-blocks", "--scalar-replacement=0", "--ssa-rewrite", "--ccp", "--simplify-instructions"] * 3, "--simplify-instructions", "--redundancy-elimination",
          "--eliminate-dead-branches", "--merge-blocks", "--eliminate-dead-code-aggressive"]
FREE = {"OpLabel", "OpBranch", "OpBranchConditional", "OpSelectionMerge", "OpFunction", "OpFunctionEnd", "OpReturn", "OpAccessChain",
        "OpCompositeConstruct", "OpCompositeExtract", "OpCompositeInsert", "OpVectorShuffle", "OpPhi", "OpBitcast", "OpVariable", "OpUndef",
        "OpStore", "OpCopyObject"}


def run(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def disassembly(folder, main, defines):
    with open(os.path.join(ROOT, "runtime_eval/shader_grid/look_up.glsl"), encoding="utf-8") as file:
        look_up = file.read().replace("for (int", "[[unroll]] for (int")
    source, module = os.path.join(folder, "shader.comp"), os.path.join(folder, "shader.spv")
    with open(source, "w", encoding="utf-8") as file:
        file.write(HEAD + look_up + main)
    run("glslangValidator", "--quiet", "-V", "--target-env", "vulkan1.1", *["-D" + define for define in defines + LIGHT], "-o", module, source)
    run("spirv-opt", *PASSES, module, "-o", module)
    text = run("spirv-dis", module)
    if "OpLoopMerge" in text:
        sys.exit(f"{defines}: a loop was not unrolled")
    return text


def count(text):
    """Operations and reads of the one function that is left."""
    width = {name: int(size) for name, size in re.findall(r"(%\w+) = OpTypeVector %\w+ (\d)", text)}
    names = dict(re.findall(r'OpName (%\w+) "(\w*)"', text))
    structure = {variable: names.get(kind) for variable, kind in
                 ((v, re.search(rf"{re.escape(p)} = OpTypePointer \w+ (%\w+)", text).group(1)) for v, p in
                  re.findall(r"(%\w+) = OpVariable (%\w+) StorageBuffer", text))}
    found = collections.Counter()
    pointer = {}
    for line in text[text.index("OpFunction "):].splitlines():
        operation = re.search(r"\b(Op\w+)", line)
        if not operation:
            continue
        operation = operation.group(1)
        if operation == "OpAccessChain":
            result, base = re.match(r"\s*(%\w+) = OpAccessChain %\w+ (%\w+)", line).groups()
            pointer[result] = structure.get(base)
        if operation == "OpLoad":
            source = pointer.get(re.search(r"OpLoad %\w+ (%\w+)", line).group(1))
            found["words"] += source == "Words"
            found["fours"] += source == "Fours"
        elif operation not in FREE:
            kind = re.search(r"= Op\w+ (%\w+)", line)
            numbers = width.get(kind.group(1), 1) if kind else 1
            if operation == "OpDot":
                found["float"] += 7  # of vectors of four, as nearly all are
            elif operation.startswith("OpF") or operation in ("OpExtInst", "OpVectorTimesScalar", "OpConvertSToF"):
                found["float"] += numbers
            else:
                found["integer"] += numbers
    return found


def main():
    print("| | reads: words, fours | bytes | float operations | integer operations | traversal's share |")
    print("|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for grid, defines in GRIDS.items():
            whole, traversal = (count(disassembly(folder, text, defines)) for text in (WHOLE, TRAVERSAL))
            share = (traversal["float"] + traversal["integer"]) / (whole["float"] + whole["integer"])
            print(f"| {grid} | {whole['words']}, {whole['fours']} | {4 * whole['words'] + 16 * whole['fours']:,} | {whole['float']:,} | "
                  f"{whole['integer']:,} | {100 * share:.0f} % |")


if __name__ == "__main__":
    main()
