"""The curve of one training run: log.csv → PNG."""
import argparse
import io
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # tool/, which all scripts share
from tool.atomic_file import write_atomically
from tool.errors import run
from training_so_far import read_curve


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--log", required=True, help="training curve of nlg-train (.csv)")
    parser.add_argument("--title", required=True)
    parser.add_argument("--out", required=True, help="picture to write (.png)")
    options = parser.parse_args()
    rows = read_curve(options.log)
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
    axes.set(title=options.title, xlabel="training step (dotted: after a rollback)", yscale="log")
    axes.grid(True, which="both", linewidth=0.3)
    axes.legend()
    # no time and no version inside: the same log gives the same bytes
    picture = io.BytesIO()
    figure.savefig(picture, format="png", dpi=130, metadata={"Software": None})
    write_atomically(options.out, picture.getvalue())


if __name__ == "__main__":
    sys.exit(run("training_curve", main))
