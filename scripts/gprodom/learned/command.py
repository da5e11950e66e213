"""``gprodom learn``: trains the networks on simulated ground, and on sequences with truth."""

import argparse
import hashlib
import json
import os
import subprocess
import time
from pathlib import Path
from typing import Any

import numpy as np

import gprodom
from gprodom.console import Progress, add_json_flag, tell
from gprodom.errors import Error, UsageError
from gprodom.files import OutputFolder, replacing, write_bytes
from gprodom.learned.drives import drive_examples
from gprodom.learned.examples import joined, make_examples
from gprodom.learned.grounds import KEPT, seeds
from gprodom.learned.model import NETWORKS, RECORD
from gprodom.odometry.replay import run_telling
from gprodom.options import Subparsers, add_command

PARTS = ("train", "validate")
MADE_BY = ("split.json", "grounds.py", "windows.py", "examples.py", "drives.py")  # the examples
TRAINED_BY = (*MADE_BY, "networks.py", "training.py")

DESCRIPTION = """\
Trains learned_sequential and learned_pair (scripts/gprodom/learned/README.md) on passes over
simulated grounds, whose seeds and split are fixed (split.json beside it), on the FDTD lines that
come with the package, and on the sequences SEQ, which must have truth; validates on grounds that
are not trained on. Writes the networks as ONNX, a checkpoint of each and record.json. An
interrupted training goes on where it was. Needs PyTorch in the python3 named by --python (Debian:
python3-torch); the examples are made first and kept, for a second training.

examples:
  gprodom learn -o networks
  gprodom learn -o quick --share 0.1 --epochs 2
  gprodom learn -o theirs 1613063428-0-gates_g-cmu-gpr.zip --lines garage,floor
  gprodom run garage.lcmlog --method learned_sequential --networks networks --tum garage.tum
"""


def add_parser(subparsers: Subparsers) -> None:
    """Adds ``learn``."""
    parser = add_command(
        subparsers, "learn", "train networks on simulated ground", DESCRIPTION, run
    )
    parser.operand("sequences", "SEQ", "with truth, to train on as well", nargs="*")
    parser.add_argument("-o", "--output", type=OutputFolder, required=True, metavar="DIR")
    parser.option("--seed SEED", 1, "of the training (default 1)")
    parser.option("--epochs EPOCHS", 4, "passes over all examples (default 4)")
    parser.option("--share 0..1", 1.0, "of the grounds (default 1)")
    parser.option(
        "--lines A,B",
        _lines,
        f"FDTD lines to train on, '' for none (default {','.join(KEPT)})",
        default=KEPT,
    )
    parser.option("--threads THREADS", 2, "of the training (default 2)")
    parser.option(
        "--python FILE",
        Path,
        "that has PyTorch (default %(default)s)",
        default=Path("/usr/bin/python3"),
    )
    add_json_flag(parser)


def _lines(text: str) -> tuple[str, ...]:
    names = tuple(name for name in text.split(",") if name)
    for name in names:
        if name not in KEPT:
            raise argparse.ArgumentTypeError(f"{name}: expected some of {', '.join(KEPT)}")
    return names


def run(args: argparse.Namespace) -> int:
    """Runs the subcommand."""
    if not 0 < args.share <= 1 or args.epochs < 1 or args.threads < 1:
        raise UsageError("expected --share above 0 and up to 1, --epochs and --threads 1 or more")
    torch = torch_version(args.python)
    folder: Path = args.output
    folder.mkdir(parents=True, exist_ok=True)
    grounds, made_s = prepare(folder, args.share, args.lines, args.sequences)
    train(args, folder)
    training = json.loads((folder / "training.json").read_text(encoding="utf-8"))
    record: dict[str, Any] = {
        "code": digest(TRAINED_BY),
        "torch": torch,
        "seed": args.seed,
        "epochs": args.epochs,
        "grounds": grounds,
        "making_ground_s": made_s,
        "bytes": {name: (folder / f"{name}.onnx").stat().st_size for name in NETWORKS},
        "training": training,
    }
    write_bytes(folder / RECORD, (json.dumps(record, indent=2) + "\n").encode())
    tell(args.json, record, describe(record))
    return 0


def torch_version(python: Path) -> str:
    """Of the PyTorch that `python` has."""
    try:
        done = subprocess.run(
            [python, "-c", "import torch; print(torch.__version__)"], capture_output=True, text=True
        )
    except OSError as error:
        raise Error(f"--python {python}: {error.strerror}") from None
    if done.returncode != 0:
        raise Error(f"{python} has no PyTorch: apt-get install python3-torch, or name another one")
    return done.stdout.strip()


def digest(names: tuple[str, ...]) -> str:
    """Of the files `names` and of the simulation."""
    package = Path(__file__).parents[1]
    files = [package / "learned" / name for name in names]
    files += [package / "simulate" / name for name in ("ground.py", "radar.py")]
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()[:16]


def prepare(
    folder: Path, share: float, lines: tuple[str, ...], sequences: list[Path]
) -> tuple[dict[str, Any], float]:
    """Makes the examples in `folder`, unless they are there: on what, and the seconds taken."""
    grounds: dict[str, Any] = {part: seeds(part, share) for part in PARTS}
    grounds |= {"lines": list(lines), "copies": seeds("copies", share)}
    grounds["sequences"] = [path.name for path in sequences]
    stamps = [(str(path.resolve()), path.stat().st_mtime) for path in sequences if path.exists()]
    key = f"{digest(MADE_BY)} {grounds} {stamps}"
    kept = folder / "examples.json"
    if kept.exists():
        known = json.loads(kept.read_text(encoding="utf-8"))
        if known["key"] == key:
            return grounds, float(known["seconds"])
        kept.unlink()
    for old in folder.glob("*.pt"):  # of other examples
        old.unlink()
    started = time.monotonic()
    parts = {part: [(seed, "") for seed in grounds[part]] for part in PARTS}
    parts["train"] += [(seed, line) for line in lines for seed in grounds["copies"]]
    with Progress("making examples", sum(map(len, parts.values())) + len(sequences)) as progress:
        for part in PARTS:
            examples = make_examples(parts[part], progress.advance)
            if part == "train":
                examples = joined([examples, *drive_examples(sequences, progress.advance)])
            with replacing(folder / f"{part}.npz") as new, new.open("wb") as file:
                np.savez(file, **examples)  # type: ignore[arg-type]
    seconds = round(time.monotonic() - started, 1)
    write_bytes(kept, json.dumps({"key": key, "seconds": seconds}).encode())
    return grounds, seconds


def train(args: argparse.Namespace, folder: Path) -> None:
    """Runs the training in the python that has PyTorch."""
    path = str(Path(gprodom.__file__).resolve().parents[1])
    command = [args.python, "-W", "ignore", "-m", "gprodom.learned.training"]
    command += [*(folder / f"{part}.npz" for part in PARTS), folder]
    command += ["--seed", args.seed, "--epochs", args.epochs, "--threads", args.threads]
    streams: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    streams["env"] = {**os.environ, "PYTHONPATH": path}
    with Progress("training", 1.0) as progress:
        code, said = run_telling([str(word) for word in command], progress.update, **streams)
    if code != 0:
        raise Error(f"the training failed: {said or code}")


def describe(record: dict[str, Any]) -> str:
    """The figures of validation, in words."""
    training = record["training"]
    way, pair = training["learned_sequential"], training["learned_pair"]
    lines = [
        f"examples made in {record['making_ground_s']:.0f} s, trained in "
        f"{training['training_s']:.0f} s; on {len(record['grounds']['validate'])} other grounds:",
        f"learned_sequential: {way['weights']} weights; error of the spacing's logarithm "
        f"{way['rms_log']:.3f}, R2 {way['r2_log']:.3f}, NEES {way['nees']:.2f}",
        f"learned_pair: {pair['weights']} weights; median error on the same ground "
        f"{1e3 * pair['median_m']:.0f} mm, {100 * pair['recall']:.0f} % accepted",
    ]
    return "\n".join(lines)
