#!/usr/bin/python3
"""nlg-train as a whole: from memory and from a cache, stopped and resumed, by several processes, on numbers that go wrong.

    training_test.py BIN_FOLDER [ROUNDS]
"""
import csv
import hashlib
import json
import math
import os
import shutil
import signal
import struct
import subprocess
import sys
import time
from random import Random

sys.dont_write_bytecode = True
os.environ["NLG_PROGRESS"] = "off"  # a stage of more than a second is a line of its own
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from tools import INPUT_ERROR, NUMERICAL_ERROR, SECONDS, USAGE_ERROR, Tools, read, room, run_checks, write

TOOLS = Tools(sys.argv[1])
check = TOOLS.check
# a poisoned coefficient is read by a generator of coefficients alone
OPTIONS = ["--input", "coefficients", "--batch", "8", "--checkpoint-steps", "10", "--start-candidates", "1", "--width", "24", "--layers", "2",
           "--theta-share", "0.25"]
INPUTS = ["--representation", "tent_mlp", "--basis", "basis.h5", "--held-out", "held_out.h5"]
CACHE = ["--cache", "functions.cache"]
HEAD, POINTS, VALIDITY, SUMS, BLOCK = 4096, 8192, 1024, 8192, 512  # docs/reference/training_files.md, "Function cache"
ROUNDS = int(sys.argv[2]) if len(sys.argv) > 2 else 2  # of stops by every signal, for each kind of run


def start(tool, *arguments, **more):
    return subprocess.Popen([os.path.join(TOOLS.folder, tool), *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more)


def end(process, expected=0):
    out, err = process.communicate(timeout=2 * SECONDS)
    if process.returncode != expected:
        TOOLS.end()
        sys.exit(f"{' '.join(process.args)}: exit code {process.returncode}, expected {expected}\n{err}")
    return out, err


def train(name, *more, data=CACHE, steps=120, learning_rate="0.003", flags=(), **how):
    # the last one of an option counts
    options = {}
    for option, value in zip(*[iter([*INPUTS, *OPTIONS, *data, "--steps", str(steps), "--learning-rate", learning_rate, "--out", f"{name}.ckpt", "--run", f"{name}_run", "--log", f"{name}.csv", *more])] * 2):
        options[option] = value
    return start("nlg-train", *(word for pair in options.items() for word in pair), *flags, **how)


def columns(path):
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    return {key: [float(row[key]) for row in rows] for key in rows[0]}


def changed_cache(path, change):
    """A copy of the function cache after change(records, size of one), with digests that fit."""
    whole = bytearray(read("functions.cache"))
    footer_first = struct.unpack_from("<Q", whole, 16)[0]
    json_text, _, tail = bytes(whole[footer_first:]).partition(b"\n")
    values = json.loads(json_text)
    size = POINTS + 2 * VALIDITY + SUMS + 4 * values["coefficient_count"]
    records = whole[HEAD:footer_first]
    change(records, size)
    values["block_sha256"] = [hashlib.sha256(records[i : i + BLOCK * size]).hexdigest() for i in range(0, len(records), BLOCK * size)]
    footer = json.dumps(values).encode() + b"\n" + tail
    whole[24:88] = hashlib.sha256(footer).hexdigest().encode()
    write(path, bytes(whole[:HEAD] + records) + footer)


def make_extreme(records, size):
    """Of every five functions one of nothing but 255, one of nothing but 0, one without a valid point."""
    for number in range(len(records) // size):
        if number % 5 < 3:
            phi, validity = ((255, 255), (0, 255), (0, 0))[number % 5]
            records[number * size:number * size + POINTS + VALIDITY] = bytes([phi]) * POINTS + bytes([validity]) * VALIDITY


def check_cores(_):
    """On one core, and with as many threads as OpenBLAS would take by itself, the basis has the same bytes."""
    environment = {name: value for name, value in os.environ.items() if name not in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")}
    for cores in (os.sched_getaffinity(0), {min(os.sched_getaffinity(0))}):
        end(start("nlg-pca", "--components", "16", "--shards", "training.h5", "--held-out", "held_out.h5", "--out", "cores.h5", env=environment,
                  preexec_fn=lambda cores=cores: os.sched_setaffinity(0, cores)))
        check(read("cores.h5") == read("basis.h5"), f"{len(cores)} cores give another basis")


def check_cache(_):
    """The same functions in the same order, from memory and from the disk."""
    end(train("memory", data=["--shards", "training.h5"]))
    end(train("disk"))
    memory, disk = columns("memory.csv")["held_out_blend_rmse"], columns("disk.csv")["held_out_blend_rmse"]
    check(all(abs(a - b) < 2e-5 for a, b in zip(memory, disk)), f"training from memory and from the disk differ: {memory}, {disk}")
    check(len(disk) == 12 and disk[-1] < disk[0], f"the held-out error did not fall: {disk}")
    left = sorted(name for name in os.listdir("disk_run") if not name.startswith("worst-"))
    check(len(os.listdir("disk_run")) - len(left) == 12, f"pictures of each validation are to be made of {os.listdir('disk_run')}")
    check(left == [".lock", "config.json", "latest", "log.csv", "provenance.json", "step-000000110.ckpt", "step-000000120.ckpt"], f"the run left {left}")
    check(os.readlink("disk_run/latest") == "step-000000120.ckpt", "latest is not the last checkpoint")
    _, err = end(start("nlg-export", "--checkpoint", "disk_run/step-000000110.ckpt", "--basis", "basis.h5", "--shards", "held_out.h5", "--parity-tolerance", "1", "--out", "early.safetensors"))
    check(err == "nlg-export: disk_run/step-000000110.ckpt is unfinished: step 110 of 120\n", f"an unfinished checkpoint: {err!r}")
    check(read("disk_run/log.csv") == read("disk.csv"), "the run's curve is not the one asked for")
    check(json.load(open("disk_run/config.json"))["steps"] == 120, "config.json does not hold the options")
    check(set(json.load(open("disk_run/provenance.json"))["inputs"]) == {"basis", "training_set"}, "provenance.json lacks inputs")


def check_damaged_checkpoint(_):
    """The newest checkpoint is cut short: the one before it goes on, to the same bytes. All are: the run is refused."""
    end(train("damaged", steps=60))
    whole = read("damaged.ckpt")
    newest = "damaged_run/step-000000060.ckpt"
    with open(newest, "r+b") as file:
        file.truncate(len(whole) // 2)
    _, err = end(train("damaged", steps=60))
    check("left out" in err and newest in err and "step 50" in err, f"a damaged checkpoint: {err!r}")
    check(read("damaged.ckpt") == whole and read(newest) == whole, "going on from the checkpoint before the damaged one ends in other bytes")
    for name in os.listdir("damaged_run"):
        if name.endswith(".ckpt"):
            with open(os.path.join("damaged_run", name), "r+b") as file:
                file.truncate(1000)
    end(train("damaged", steps=60), INPUT_ERROR)


def folder_of(name):
    """All that a run leaves: path → bytes."""
    paths = [f"{name}.ckpt", f"{name}.csv", *(os.path.join(folder, file) for folder, _, files in os.walk(f"{name}_run") for file in files)]
    return {path.removeprefix(name): read(path) for path in paths}


def check_stops(_):
    """Stopped at random moments by every signal, also between rollbacks: the same command ends in the bytes of an unbroken run."""
    random = Random(1)
    for name, steps, more in (("plain", 400, ()), ("rolling", 120, ("--cache", "poisoned.cache"))):
        begin = time.time()
        _, err = end(train(f"unstopped_{name}", *more, steps=steps))
        took_s = time.time() - begin
        check(("rollback" in err) == (name == "rolling"), f"{name}: {err!r}")
        stops = {stop: 0 for stop in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL)}
        for stop in [*stops] * ROUNDS:
            process = train(name, *more, steps=steps)
            try:
                process.wait(random.uniform(0.2, 0.9) * took_s)
            except subprocess.TimeoutExpired:
                process.send_signal(stop)
            _, err = process.communicate()
            if process.returncode == 0:  # it was done: the next one begins anew
                check(folder_of(name) == folder_of(f"unstopped_{name}"), f"{name}: a stopped run leaves other bytes")
                shutil.rmtree(f"{name}_run")
                continue
            check(process.returncode == -stop, f"{name}, {stop}: {process.returncode}, {err!r}")
            stops[stop] += 1
        end(train(name, *more, steps=steps))
        check(sum(stops.values()) >= ROUNDS, f"{name} was hardly stopped: {stops}")
        check(folder_of(name) == folder_of(f"unstopped_{name}"), f"{name}: a stopped run leaves other bytes")


def check_ignored_stop(_):
    """Who starts it so that Ctrl-C is ignored gets a whole run."""
    process = train("ignoring", steps=400, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN))
    while process.poll() is None and not os.path.exists("ignoring_run/latest"):
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    end(process)
    check(folder_of("ignoring") == folder_of("unstopped_plain"), "an ignored Ctrl-C changed the run")


def check_other_runs(_):
    """Other options, another held-out set: refused in words; more steps: said."""
    for name, expected in (("plain", "learning_rate: 0.003, asked 0.01"), ("fewer", "steps: 400, asked 100"), ("held_out", "held_out_sha256")):
        more = ["--held-out", "other.h5"] if name == "held_out" else []
        _, err = end(train("plain", *more, steps=100 if name == "fewer" else 400, learning_rate="0.01" if name == "plain" else "0.003"), INPUT_ERROR)
        check(expected in err and "--restart-on-change" in err, f"{name}: {err!r}")
    _, err = end(train("plain", steps=420))
    check("an extended run" in err and json.load(open("plain_run/config.json"))["steps"] == 420, f"more steps: {err!r}")
    # of a run that is given up nothing stays, its pictures neither
    with open("plain_run/worst-000000007.png", "wb"):
        pass
    _, err = end(train("plain", flags=["--restart-on-change"], steps=20))
    check("starting afresh" in err and not os.path.exists("plain_run/worst-000000007.png"), f"begun again: {err!r}")


def check_copies(tools):
    """A held-out scene that is a copy of a training scene under another name is refused, and so is one that --init has seen."""
    write("room.obj", room(0))
    os.makedirs("copies", exist_ok=True)
    shutil.copy("room.obj", "copies/other.obj")
    for scene, out in (("room.obj", "--out room.h5"), ("copies/other.obj", "--held-out --out copy.h5")):
        tools.must(f"nlg-datagen --scene {scene} --max-functions 60 --spacing-min-m 0.5 --spacing-max-m 0.5 {out}")
    tools.must("nlg-pca --components 16 --shards room.h5 --out room_basis.h5")
    basis = ["--basis", "room_basis.h5"]
    _, err = end(train("copied", *basis, "--held-out", "copy.h5", data=["--shards", "room.h5"], steps=2), INPUT_ERROR)
    check("scene other" in err and "the training scene room" in err, f"a copy: {err!r}")
    # weights that saw the room, trained on another scene
    end(train("seeing", *basis, data=["--shards", "room.h5"], steps=2))
    export = ("--checkpoint", "seeing.ckpt", "--basis", "room_basis.h5", "--parity-tolerance", "1", "--out", "seeing.safetensors")
    # says that its error is of scenes that were trained on, and keeps silent about others
    _, err = end(start("nlg-export", *export, "--shards", "copy.h5"))
    check("other of --shards was trained on, as room" in err, f"an error of trained scenes: {err!r}")
    _, err = end(start("nlg-export", *export, "--shards", "held_out.h5"))
    check(err == "", f"an error of unseen scenes: {err!r}")
    tools.must("nlg-pca --from seeing.safetensors --shards training.h5 --out seeing_basis.h5")
    _, err = end(train("tuned", "--init", "seeing.safetensors", "--basis", "seeing_basis.h5", "--held-out", "copy.h5", data=["--shards", "training.h5"], steps=2), INPUT_ERROR)
    check("scene other" in err and "the training scene room" in err, f"a copy of what --init saw: {err!r}")


def check_bare_tent(_):
    """A learning rate that learns nothing is said."""
    _, err = end(train("wild", "--divergence-ratio", "1e9", steps=30, learning_rate="10"))
    log = columns("wild.csv")
    check("worse than the bare tent" in err and log["held_out_network_blend_rmse"][-1] > log["bare_tent_blend_rmse"][-1] > 0, f"a learning rate of 10: {err!r}, {log}")


def check_other_process(_):
    """Processes that do not train the same are refused before they take a step."""
    pair = [train("odd", "--rank", str(rank), "--processes", "2", "--rendezvous", "odd_meeting", "--seed", str(1 + rank)) for rank in range(2)]
    for rank, process in enumerate(pair):
        _, err = end(process, INPUT_ERROR)
        check("process" in err and len(err.splitlines()) == 1, f"process {rank} of another run: {err!r}")
    check(not os.path.exists("odd_run/latest"), "processes of two runs trained")


def compare_curves(name, keys, tolerance, *options):
    """One process and two with its batch between them: how their curves compare."""
    end(train(f"{name}_one", *options))
    pair = [train(f"{name}_two", "--rank", str(rank), "--processes", "2", "--rendezvous", f"{name}_meeting", *options) for rank in range(2)]
    for process in pair:
        end(process)
    one, two = columns(f"{name}_one.csv"), columns(f"{name}_two.csv")
    for key in keys:
        difference = max(abs(a - b) / b for a, b in zip(one[key], two[key]))
        check(difference <= tolerance, f"two processes, {name}: {key} is off by a share of {difference}")
    return one, two


def check_processes(_):
    """Two processes with the batch of one: the same curve, to rounding."""
    # the sums of floats differ in their order: 1e-7 of the gradient a step, printed with six digits
    one, two = compare_curves("plain", ["training_loss", "held_out_blend_rmse"], 2e-4, "--exact-last-layer=false")
    # exact last layers are steep: what goes into them at 1e-7 comes out at 1e-2 after three steps of so rough a run, and the stages
    # behind them go their own ways; the generator before them does not
    compare_curves("corrected", ["held_out_network_blend_rmse"], 0.01)
    check(one["step"] == two["step"], f"two processes: other steps: {two['step']}")


def check_lost_process(_):
    pair = [train("lost", "--rank", str(rank), "--processes", "2", "--rendezvous", "lost_meeting", "--timeout-s", "20", steps=1000000)
            for rank in range(2)]
    deadline = time.time() + 60
    while not os.path.exists("lost_run/latest") and time.time() < deadline:
        time.sleep(0.01)
    # one trainer a folder
    end(train("lost", steps=1000000), USAGE_ERROR)
    pair[1].kill()
    pair[1].communicate()
    _, err = end(pair[0], INPUT_ERROR)
    check("lost_meeting" in err and len(err.splitlines()) == 1, f"a lost process is reported as {err!r}")


def check_rollbacks(_):
    """A function whose coefficients are absurd: training goes back, and says so."""
    changed_cache("poisoned.cache", lambda records, size: struct.pack_into("<f", records, 3 * size + POINTS + 2 * VALIDITY + SUMS, 1e30))
    data = ["--cache", "poisoned.cache"]
    out, err = end(train("poisoned", data=data))
    result = json.loads(out)
    rollbacks = columns("poisoned.csv")["rollbacks"]
    check(0 < result["rollbacks"] <= 5 and rollbacks[-1] == result["rollbacks"], f"rollbacks: {result}, {rollbacks}")
    check(err.count("rollback") == result["rollbacks"], f"stderr tells of other rollbacks: {err}")
    check(result["held_out_blend_rmse"] < columns("poisoned.csv")["held_out_blend_rmse"][0], "a run with rollbacks did not learn")
    _, err = end(train("lasting", data=data, steps=2000), NUMERICAL_ERROR)
    check("after 5 rollbacks" in err, f"a run that cannot go on says {err}")
    check(os.path.exists("lasting_run/latest"), "a run that gave up left no checkpoint")


def check_wild_rates(_):
    """No error of a checkpoint is ever not finite: the run goes on at half the rate, or ends with the cause."""
    for rate in ("1", "1000"):
        process = train(f"rate_{rate}", learning_rate=rate)
        _, err = process.communicate()
        errors = columns(f"rate_{rate}_run/log.csv")["held_out_blend_rmse"] if os.path.exists(f"rate_{rate}_run/latest") else []
        check(all(map(math.isfinite, errors)), f"rate {rate}: {errors}")
        check(process.returncode == NUMERICAL_ERROR and "step" in err or process.returncode == 0 and errors, f"rate {rate}: exit code {process.returncode}, {err!r}")


def check_extreme_targets(_):
    changed_cache("extreme.cache", make_extreme)
    end(train("extreme", data=["--cache", "extreme.cache"]))
    errors = columns("extreme.csv")["held_out_blend_rmse"]
    check(all(map(math.isfinite, errors)), f"targets of 0 and 255 alone: {errors}")


def checkpointed(name, data, steps=120):
    """A run that has made its first checkpoint."""
    process = train(name, data=data, steps=steps)
    deadline = time.time() + SECONDS
    while process.poll() is None and not os.path.exists(f"{name}_run/latest") and time.time() < deadline:
        time.sleep(0.01)
    return process


def check_vanished_data(_):
    """What was read is no longer needed; a cache that is cut short ends the run, whose last checkpoint stays."""
    shutil.copy("training.h5", "vanishing.h5")
    process = checkpointed("vanishing", ["--shards", "vanishing.h5"])
    os.remove("vanishing.h5")
    end(process)
    _, err = end(train("again", data=["--shards", "vanishing.h5"]), INPUT_ERROR)
    check("vanishing.h5" in err, f"a shard that is gone: {err!r}")
    shutil.copy("functions.cache", "vanishing.cache")
    process = checkpointed("unlinked", ["--cache", "vanishing.cache"])
    os.remove("vanishing.cache")
    end(process)
    end(train("undisturbed"))
    check(read("unlinked.ckpt") == read("undisturbed.ckpt"), "a cache that vanished midway changed the run")
    shutil.copy("functions.cache", "cut.cache")
    process = checkpointed("cut", ["--cache", "cut.cache"], steps=1000000)
    os.truncate("cut.cache", 3 * HEAD)
    _, err = end(process, INPUT_ERROR)
    check("cache" in err and os.path.exists("cut_run/latest"), f"a cache that is cut short: {err!r}")


def make_inputs(tools):
    for command in ("nlg-datagen --scene house:1 --max-functions 700 --out training.h5", "nlg-datagen --scene house:2 --max-functions 24 --held-out --out held_out.h5",
                    "nlg-datagen --scene house:3 --max-functions 24 --held-out --out other.h5",
                    "nlg-pca --components 16 --shards training.h5 --held-out held_out.h5 --out basis.h5", "nlg-cache --basis basis.h5 --shards training.h5 --out functions.cache"):
        tools.must(command)


if __name__ == "__main__":
    sys.exit(run_checks(TOOLS, (make_inputs, check_cores, check_cache, check_damaged_checkpoint, check_other_process, check_processes, check_lost_process, check_rollbacks, check_stops, check_ignored_stop, check_other_runs, check_copies, check_bare_tent, check_wild_rates, check_extreme_targets, check_vanished_data)))
