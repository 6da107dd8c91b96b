"""Finds levels that are copies, before anything is made: known by their geometry, whatever else is in their files, and whatever they are called.

    copies.py CONFIG [--levels FOLDER] [--set SECTION.KEY=VALUE]... --bin FOLDER

A copy, or a collected shard, of what must not be trained on is refused; nlg-train would do that after hours. Copies on one side of the split are
named. Interiors are not compared: each seed is another one.
"""
import argparse
import itertools
import json
import os
import shlex
import sys
from concurrent.futures import ThreadPoolExecutor

import configuration
from plain_yaml import ConfigurationError
from plan import told
from settings import rows_of
from tool.errors import run

READING = {row["name"] for row in rows_of("datagen") if row.get("group") == "Scene"}  # settings on which the geometry depends


def digest_of(binaries, of_run, scene):
    options = {**of_run.sections["datagen"], **of_run.scene_options(scene)}
    words = shlex.split(configuration.flags({key: value for key, value in options.items() if key in READING}))
    return told(binaries, "info", "--digest", *words, of_run.scenes[scene][0]).split()[0]


def refuse_copies(of_run, digests, shards):
    """digests: of each level; shards: what nlg-datagen says of each collected one."""
    kept = {*of_run.held_out, *of_run.evaluation}
    for _, same in itertools.groupby(sorted(digests, key=digests.get), digests.get):
        same = sorted(same)
        not_trained, trained = ([scene for scene in same if (scene in kept) == is_kept] for is_kept in (True, False))
        if not_trained and trained:
            raise ConfigurationError(f"split: {not_trained[0]} is not to be trained on, and {trained[0]} is the same level: take one of them away, or hold out both")
        if len(same) > 1:
            print(f"pipeline.sh: {', '.join(same)}: the same level", file=sys.stderr)
    for path, shard in shards.items():
        for scene in sorted(kept):
            if shard["scene"] == scene or shard["origin"]["inputs"].get("scene") == digests.get(scene, "none"):
                raise ConfigurationError(f"scenes: collected: {path} is of {scene}, which is not to be trained on: take it away")


def main():
    parser = argparse.ArgumentParser(prog="pipeline.sh")
    configuration.add_arguments(parser)
    parser.add_argument("--bin", required=True)
    arguments = parser.parse_args()
    of_run = configuration.judge(configuration.content_of(arguments), arguments.config)
    levels = [scene for scene, (_, files) in of_run.scenes.items() if files and scene not in of_run.unjittered]
    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        digests = dict(zip(levels, pool.map(lambda scene: digest_of(arguments.bin, of_run, scene), levels)))
        shards = dict(zip(of_run.collected, pool.map(lambda path: json.loads(told(arguments.bin, "info", "--json", path)), of_run.collected)))
    refuse_copies(of_run, digests, shards)


if __name__ == "__main__":
    sys.exit(run("pipeline.sh", main))
