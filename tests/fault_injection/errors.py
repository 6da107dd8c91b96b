"""Injected errors: a system call or an allocation of a tool fails, or a write ends early.

The tool either ends well with the files of an undisturbed run, or with a documented exit code, one line and no torn or temporary file.
"""
import chain
import injector
import trial
from case import Case, random_of

# Without memory or threads an exit code of 1 with one line is as good as any.
WITHOUT_MEMORY = (trial.INTERNAL_ERROR, *trial.DOCUMENTED)


def fail_call(injection, tool, made, random):
    def run(folder, faults):
        chain.lay_out(injection.store, tool, folder)
        counts = injection.counts[tool.name]
        if tool.is_script:  # Python itself has no answer to these
            counts = {name: count for name, count in counts.items() if name not in ("memory", "thread")}
        settings, word = injector.draw_error(random, counts)
        ending = trial.run(tool.argv(injection), folder, injector.injecting(injection, folder, tool.program(), **settings), injection.limits)
        codes = WITHOUT_MEMORY if settings["call"] in ("memory", "thread", "map") else trial.DOCUMENTED
        trial.judge(ending, injection.limits, faults, codes, is_quiet=not made.stderr)
        left = chain.outputs_in(tool, folder)
        for path in left:
            if chain.is_temporary(path):
                faults.add(trial.LEFT, f"{path} stays")
            elif path in made.listing and not made.is_whole(folder, path):
                faults.add(trial.TORN, f"{path} is torn")
        for path in made.listing if ending.code == 0 else ():
            if path not in left or not made.is_final(folder, path):
                faults.add(trial.SILENT, f"success, and {path} is not what it should be")
        return f"{tool.name}: {word}: {ending.words()}"
    return run


def cases(injection, count):
    for number in range(count):
        random = random_of(injection, "errors", number)
        tool = injection.draw_tool(random, injection.tools)
        yield Case(f"errors/{number}", "injected errors", fail_call(injection, tool, injection.made[tool.name], random)), 1
