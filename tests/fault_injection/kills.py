"""Kills: of single tools at single system calls, and of whole pipelines at random moments.

After each: what has a finished file's name is whole, and a restart ends in the files of a run that nothing disturbed.
"""
import chain
import injector
import trial
from case import Case, random_of
from pipeline import Pipeline

SILENT_TOOLS = ("datagen plan", "datagen info")  # they write nothing
# moments within a second of each other meet other stages; a run of the whole pipeline takes about 40
PIPELINE_KILL_SECONDS = (0.5, 12.0)
KILLS_OF_A_PIPELINE = 12


def check_whole(tool, made, folder, faults, when):
    for path in chain.outputs_in(tool, folder):
        if not chain.is_temporary(path) and path in made.listing and not made.is_whole(folder, path):
            faults.add(trial.TORN, f"{when}: {path} is torn")


def check_ended(tool, made, folder, faults):
    """After the last run: the files of an undisturbed one, all of them and no others."""
    left = chain.outputs_in(tool, folder)
    for path in sorted(set(left) - set(made.listing)):
        faults.add(trial.LEFT, f"{path} stays after a restart")
    for path in made.listing:
        if path not in left:
            faults.add(trial.TORN, f"{path} is missing after a restart")
        elif not made.is_final(folder, path):
            faults.add(trial.TORN, f"{path} is another file after a restart")


def kill_tool(injection, tool, made, random):
    def run(folder, faults):
        chain.lay_out(injection.store, tool, folder)
        words = []
        # a second kill meets what the first one left
        for _ in range(random.choice((1, 1, 2))):
            settings, word = injector.draw_kill(random, injection.counts[tool.name])
            words.append(word)
            ending = trial.run(tool.argv(injection), folder, injector.injecting(injection, folder, tool.program(), **settings), injection.limits)
            if ending.hung:
                faults.add(trial.HANG, ending.words())
            check_whole(tool, made, folder, faults, word)
        ending = trial.run(tool.argv(injection), folder, injection.environment, injection.limits)
        trial.judge(ending, injection.limits, faults, is_quiet=False)
        if ending.code != 0:
            faults.add(trial.ENDING, f"restart: {ending.words()}")
        check_ended(tool, made, folder, faults)
        return f"{tool.name}: {', '.join(words)}"
    return run


def kill_pipeline(injection, random, kills):
    """One run from nothing, killed again and again, and let go on until it is done."""
    def run(folder, faults):
        pipeline = Pipeline(injection, folder)
        words = []
        for _ in range(kills):
            seconds = random.uniform(*PIPELINE_KILL_SECONDS)
            ending = pipeline.run(kill_after=seconds)
            words.append(f"{seconds:.1f} s")
            pipeline.check_whole(injection.pipeline, faults, f"killed after {', '.join(words)}")
            if ending.code == 0:
                words.append("done, and from nothing again")
                pipeline.clear()
        pipeline.finish(injection.pipeline, faults)
        return f"killed after {', '.join(words)}"
    return run


def cases(injection, count):
    """About a quarter of the kills are of whole pipelines."""
    kills = min(KILLS_OF_A_PIPELINE, count // 4)
    runs = count // 4 // kills if injection.pipeline else 0
    for number in range(runs):
        yield Case(f"kills/pipeline/{number}", "kills of whole pipelines", kill_pipeline(injection, random_of(injection, "kills", "pipeline", number), kills)), kills
    tools = [tool for tool in injection.tools if tool.name not in SILENT_TOOLS]
    for number in range(count - runs * kills):
        random = random_of(injection, "kills", number)
        tool = injection.draw_tool(random, tools)
        yield Case(f"kills/call/{number}", "kills at single system calls", kill_tool(injection, tool, injection.made[tool.name], random)), 1
