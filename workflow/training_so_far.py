"""What there is to see of a training: its curve for TensorBoard and as a picture, and after every validation a picture of its worst held-out functions.

    training_so_far.py --run FOLDER --log FILE.csv [--follow PARENT]
    training_so_far.py --curve FILE.png --log FILE.csv

FOLDER is that of nlg-train: events.out.tfevents.0.nlg and worst-STEP.png come into it, each picture of a worst-STEP.json, which goes. Where several wait, the newest
is drawn. The second draws the curve, of a training at work or over.
"""
import argparse
import io
import os
import signal
import sys
import threading
from pathlib import Path

os.environ["MPLBACKEND"] = "Agg"  # Matplotlib, which takes its time, is imported where something is drawn

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # tool/, which all scripts share
from tool.atomic_file import write_atomically
from tool.errors import run
from tool.input_file import parse_number, read_columns, read_json
from tensorboard_events import append

COLUMNS = ("step", "learning_rate", "training_loss", "held_out_network_blend_rmse", "held_out_blend_rmse", "bare_tent_blend_rmse", "rollbacks")
DIFFERENCE = 0.2  # that the colours show


def read_curve(log):
    return [{key: parse_number(log, line, key, text) for key, text in zip(COLUMNS, row)} for line, row in read_columns(log, COLUMNS)]


def note_events(log, events):
    """The newest row of the curve is as old as its file."""
    time_s = os.stat(log).st_mtime
    append(events, [(int(row["step"]), {key: row[key] for key in COLUMNS[1:]}) for row in read_curve(log)], time_s)


def png(figure):
    """No time and no version inside: the same numbers give the same bytes."""
    picture = io.BytesIO()
    figure.savefig(picture, format="png", dpi=130, metadata={"Software": None})
    return picture.getvalue()


def curve(rows, title):
    import matplotlib.pyplot as plt

    steps = [row["step"] for row in rows]
    figure, axes = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
    axes.plot(steps, [row["training_loss"] for row in rows], linestyle="--", color="0.45", label="training loss")
    network, corrected = ([row[key] for row in rows] for key in ("held_out_network_blend_rmse", "held_out_blend_rmse"))
    if network != corrected:
        axes.plot(steps, network, marker="o", markersize=2.5, color="#56B4E9", label="held-out blend RMSE, network alone")
    axes.plot(steps, corrected, marker="o", markersize=3, color="#0072B2", label="held-out blend RMSE")
    axes.axhline(rows[-1]["bare_tent_blend_rmse"], color="#D55E00", linewidth=1, linestyle="-.", label="the bare tent")
    for before, row in zip([{"rollbacks": 0.0}, *rows], rows):
        if row["rollbacks"] > before["rollbacks"]:
            axes.axvline(row["step"], color="0.6", linewidth=0.8, linestyle=":")
    axes.set(title=title, xlabel="training step (dotted: after a rollback)", yscale="log")
    axes.grid(True, which="both", linewidth=0.3)
    axes.legend()
    return png(figure)


def draw(path):
    """Target, prediction and difference at the support points of a plane through each function's probe."""
    import matplotlib.pyplot as plt

    file = read_json(path)
    functions = file["functions"].items()
    figure, axes = plt.subplots(max(1, len(functions)), 3, figsize=(7.2, 2.4 * max(1, len(functions))), layout="constrained", squeeze=False)
    figure.suptitle(f"step {file['step'].count()}: the worst held-out functions")
    for row, one in zip(axes, functions):
        points = [[value.number(low=-1e9) for value in point.items()] for point in one["points"].items()]
        u, v, target, predicted = zip(*points) if points else ((), (), (), ())
        difference = [b - a for a, b in zip(target, predicted)]
        plane = "yz zx xy".split()[one["axis"].count()]
        for panel, title, values, colours, low, high in ((row[0], f"no. {one['function'].count()}, target", target, "inferno", 0, 1), (row[1], "predicted", predicted, "inferno", 0, 1),
                                                         (row[2], f"difference; blend RMSE {one['blend_rmse'].number():.4f}", difference, "PuOr_r", -DIFFERENCE, DIFFERENCE)):
            panel.scatter(u, v, c=values, s=5, cmap=colours, vmin=low, vmax=high)
            panel.set(title=title, xlim=(-1, 1), ylim=(-1, 1), aspect="equal", xticks=[], yticks=[], xlabel=plane[0], ylabel=plane[1])
            panel.title.set_fontsize(8)
    write_atomically(path.with_suffix(".png"), png(figure))
    plt.close(figure)
    path.unlink()


def note(options):
    if os.path.exists(options.log):
        os.makedirs(options.run, exist_ok=True)
        note_events(options.log, os.path.join(options.run, "events.out.tfevents.0.nlg"))
    *missed, newest = sorted(Path(options.run).glob("worst-*.json")) or [None]
    for path in missed:  # validations that come faster than pictures
        path.unlink()
    if newest:
        draw(newest)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--run", help="folder of the training (nlg-train --run)")
    where.add_argument("--curve", help="picture of the curve to write (.png)")
    parser.add_argument("--log", required=True, help="its curve (nlg-train --log), there or to come")
    parser.add_argument("--follow", metavar="PARENT", type=int, help="all of it as it comes, until SIGTERM or the end of the process with this number, which started this")
    options = parser.parse_args()
    if options.curve:
        write_atomically(options.curve, curve(read_curve(options.log), Path(options.log).stem))
        return
    # who started this may be killed before it is asked for the first time: its number is given
    ended = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: ended.set())
    while options.follow is not None and not ended.wait(1) and os.getppid() == options.follow:
        note(options)
    note(options)


if __name__ == "__main__":
    sys.exit(run("training_so_far", main))
