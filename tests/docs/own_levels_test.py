#!/usr/bin/python3
"""The Python of docs/guide/training.md does what the page says, on a shard of nlg-datagen's. own_levels_test.py BIN_FOLDER"""
import importlib.util
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MOST_LINES = 10


def main():
    missing = [name for name in ("h5py", "torch", "matplotlib") if importlib.util.find_spec(name) is None]
    if missing:
        print(f"skipped: {', '.join(missing)} not installed")
        return 77
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "docs/guide/training.md").read_text(), flags=re.DOTALL)
    assert len(blocks) == 2, blocks
    with tempfile.TemporaryDirectory() as folder:
        datagen = [Path(sys.argv[1]) / "nlg-datagen", "--scene", "house:0", "--max-functions", "48", "--out", f"{folder}/SHARD.h5"]
        subprocess.run(datagen, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for block in blocks:
            assert len(block.splitlines()) <= MOST_LINES, f"{len(block.splitlines())} lines:\n{block}"
            said = subprocess.run(["/usr/bin/python3", "-c", "import matplotlib; matplotlib.use('agg')\n" + block], cwd=folder, capture_output=True, text=True)
            assert said.returncode == 0, f"{block}\n{said.stderr}"
            print(said.stdout, end="")
        assert (Path(folder) / "function.png").stat().st_size > 5000, "no picture of a function"
        loss = float(re.search(r"tensor\(([\d.]+)", said.stdout)[1])
        assert 0 < loss < 0.2, f"an autoencoder that learns nothing: {loss}"
    return 0


if __name__ == "__main__":
    sys.exit(main())
