"""What the first run found and the other parts do not draw, each finding as cases of its name.

D1, D6 and D10 are damage.py's own, D7 and D8 kills.py's, D9 errors.py's; D11, D13 and D15 need no tool killed: scripts_test.py,
configurations_test.py and CApi have them.
"""
import os
import signal
import subprocess

import chain
import hostile
import injector
import pipeline
import scenes
import trial
from case import Case, random_of

SHORT_CASES = 2  # of each finding, about, in the short form
SCENE_SECONDS, SCENE_MB = 10.0, 1000.0  # D3 to D5: what a small file may take


# ---- D2: files of others

def d2(injection):
    for tool in injection.tools:
        if tool.outputs:
            yield foreign_files(injection, tool)


def foreign_files(injection, tool):
    """Files of others beside a tool's outputs, and in its folders, by names that look like its own."""
    def run(folder, faults):
        chain.lay_out(injection.store, tool, folder)
        made, names = injection.made[tool.name], ["notes.txt"]
        for output in tool.outputs:
            if os.path.isdir(os.path.join(made.folder, output)):
                names += [f"{output}/notes.txt", f"{output}/notes.tmp", f"{output}/step-old.ckpt.bak", f"{output}/other.safetensors.bak"]
            else:
                names += [f"{output}.tmp", f"{output}.tmp.elsewhere.1.0", f"{output}.damaged", f"{output}.bak"]
        for name in names:
            os.makedirs(os.path.dirname(os.path.join(folder, name)), exist_ok=True)
            with open(os.path.join(folder, name), "w") as file:
                file.write(name)
        ending = trial.run(tool.argv(injection), folder, injection.environment, injection.limits)
        trial.judge(ending, injection.limits, faults, is_quiet=False)
        for name in names:
            path = os.path.join(folder, name)
            if not os.path.exists(path) or chain.read(path).decode() != name:
                faults.add(trial.TORN, f"{name}, a file of others, was touched")
        return f"{tool.name}: {ending.words()}"
    return run


# ---- D3, D4, D5: small files that ask for much

def small_scene(injection, file, make, reader="render"):
    def run(folder, faults):
        return scenes.read_scene(injection, file, make(), reader, folder, faults, seconds=SCENE_SECONDS, peak_mb=SCENE_MB)
    return run


def d3(injection):
    yield small_scene(injection, "scene.pk3", hostile.many_scans)


def d4(injection):
    yield small_scene(injection, "scene.pk3", hostile.one_texture_often)


def d5(injection):
    for count, length in ((24, (1 << 24) - 1), (100, (1 << 24) - 1), (1000, (1 << 22) - 1)):
        yield small_scene(injection, "scene.gltf", lambda count=count, length=length: hostile.accessors_of_zeros(count, length), "datagen")


def d12(injection):
    yield large_buffers(injection)


def large_buffers(injection):
    def run(folder, faults):
        os.makedirs(folder)
        names = [f"{i}.bin" for i in range(4)]
        for name in names:
            with open(os.path.join(folder, name), "wb") as file:
                file.truncate(3 << 30)
        return scenes.read_scene(injection, "scene.gltf", hostile.large_buffers(names), "datagen", folder, faults, peak_mb=SCENE_MB)
    return run


# ---- D14: pipeline.sh


def d14(injection):
    if injection.pipeline:
        yield two_checkouts(injection)
        for tool in ("nlg-datagen", "nlg-validate"):
            yield orphaned_tools(injection, tool)


def two_checkouts(injection):
    """Two checkouts with one folder of results, at the same time: one is at work, the other says so, or waits."""
    def run(folder, faults):
        first = pipeline.Pipeline(injection, os.path.join(folder, "one"))
        second = pipeline.Pipeline(injection, os.path.join(folder, "two"))
        second.environment["NLG_OUT"] = first.environment["NLG_OUT"]
        started = subprocess.Popen([os.path.join(first.checkout, "pipeline.sh"), first.config], cwd=first.folder, env=first.environment, stdin=subprocess.DEVNULL,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True)
        trial.wait_for(lambda: not os.path.isdir(first.results))
        ending = second.run()
        _, errors = started.communicate(timeout=injection.pipeline_limits.seconds)
        trial.judge(ending, injection.pipeline_limits, faults, (trial.USAGE_ERROR,), is_quiet=False)
        if started.returncode != 0:
            faults.add(trial.ENDING, f"the first run: code {started.returncode}: {errors[-300:]}")
        first.finish(injection.pipeline, faults)
        return f"the second: {ending.words()}"
    return run


def orphaned_tools(injection, tool):
    """pipeline.sh and snakemake are killed while a tool is at work, which lives on: no other run begins beside it."""
    def run(folder, faults):
        checkout = pipeline.Pipeline(injection, folder)
        started = subprocess.Popen([os.path.join(checkout.checkout, "pipeline.sh"), checkout.config], cwd=folder, env=checkout.environment, stdin=subprocess.DEVNULL,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
        trial.wait_for(lambda: all(name != tool for _, name in trial.session_of(started.pid)))
        parents = [process for process, name in trial.session_of(started.pid) if not name.startswith("nlg-")]
        for process in parents:
            try:
                os.kill(process, signal.SIGKILL)
            except ProcessLookupError:
                pass
        started.wait()
        alive = [process for process, name in trial.session_of(started.pid) if name.startswith("nlg-")]
        ending = checkout.run()
        trial.judge(ending, injection.pipeline_limits, faults, (trial.USAGE_ERROR,), is_quiet=False)
        trial.wait_for(lambda: any(process in alive for process, _ in trial.session_of(started.pid)))
        checkout.finish(injection.pipeline, faults)
        return f"{len(alive)} tools lived on: {ending.words()}"
    return run


# ---- D16: words

def d16(injection):
    for reader in ("datagen", "render", "bake"):
        yield named_scene(injection, "scene.bsp", hostile.control_characters, reader, must_fail=False)
    yield named_scene(injection, "scene.gltf", hostile.draco_not_required, "datagen", must_fail=True)
    for tool in injection.tools:
        if tool.outputs and not tool.is_script:
            yield names_the_output(injection, tool)


def named_scene(injection, file, make, reader, must_fail):
    def run(folder, faults):
        return scenes.read_scene(injection, file, make(), reader, folder, faults, must_fail=must_fail)
    return run


def names_the_output(injection, tool):
    """What cannot be written is called by the name that the user gave."""
    def run(folder, faults):
        chain.lay_out(injection.store, tool, folder)
        counts = injection.counts[tool.name]
        words = []
        for call, fault in (("write", "28"), ("truncate", "28"), ("sync", "5"), ("rename", "28")):
            if not counts.get(call):
                continue
            ending = trial.run(tool.argv(injection), folder, injector.injecting(injection, folder, tool.program(), call=call, at=1, fault=fault, stay=True), injection.limits)
            trial.judge(ending, injection.limits, faults, is_quiet=not injection.made[tool.name].stderr)
            if ".tmp" in ending.stderr:
                faults.add(trial.ENDING, f"names a temporary file: {ending.words()}")
            words.append(ending.words())
        return f"{tool.name}: {'; '.join(words)}"
    return run


FINDINGS = {
    "D2: files of others": d2, "D3: a picture of 20,000 scans": d3, "D4: one texture read 40,000 times": d4, "D5: accessors that add up": d5,
    "D12: large buffers": d12, "D14: two runs of one folder": d14, "D16: words on stderr": d16,
}


def cases(injection, count):
    """All of them; count is not asked."""
    for title, make in FINDINGS.items():
        name, runs = title.split(":")[0], list(enumerate(make(injection)))
        for number, run in runs[::max(1, len(runs) // SHORT_CASES)] if injection.arguments.short else runs:
            yield Case(f"findings/{name}/{number}", title, run), 1
