"""Trains both networks on prepared examples: run by a python3 that has PyTorch.

    python3 -m gprodom.learned.training EXAMPLES.npz VALIDATION.npz DIR --seed 1 --epochs 6

Writes `progress SHARE TEXT` lines; DIR/NETWORK.onnx, DIR/NETWORK.pt (a checkpoint after each epoch,
from which an interrupted training goes on) and DIR/training.json with the figures of validation.
"""

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from gprodom.learned.networks import LEAST_SPACING, PairNet, SequentialNet
from gprodom.learned.windows import COLUMN

BATCH = 64
RATE = 2e-3  # of learning, at its highest
SAME_AT = (0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995, 0.998)  # chances to choose from
RIGHT = 0.98  # share of the accepted pairs that shall be on the same ground
PRIOR = 0.2  # share of the pairs that are on the same ground, of those that a track puts near

Examples = dict[str, Tensor]


@dataclass(frozen=True)
class Task:
    """What one network learns: its inputs, its loss and its figures on validation."""

    name: str
    make: Callable[[], nn.Module]
    inputs: tuple[str, str]
    loss: Callable[[Tensor, Examples], Tensor]
    judge: Callable[[Tensor, Examples], dict[str, Any]]


def read_examples(path: Path, names: tuple[str, ...]) -> Examples:
    """The arrays `names` of an npz."""
    with np.load(path) as data:
        return {name: torch.from_numpy(data[name]) for name in names}


def _spread(log_sigma: Tensor) -> Tensor:
    return log_sigma.clamp(-4, 2)


def spacing_loss(told: Tensor, truth: Examples) -> Tensor:
    """Negative log-likelihood of the logarithm of the spacing."""
    log_sigma = _spread(told[:, 1])
    error = told[:, 0] - torch.log(truth["spacing"].float() + LEAST_SPACING)
    return (0.5 * (error * torch.exp(-log_sigma)).square() + log_sigma).mean()


def judge_spacing(told: Tensor, truth: Examples) -> dict[str, Any]:
    """Error of the logarithm, its share that is explained, and NEES."""
    wanted = torch.log(truth["spacing"].float() + LEAST_SPACING)
    error = told[:, 0] - wanted
    nees = (error * torch.exp(-_spread(told[:, 1]))).square()
    return {
        "rms_log": float(error.square().mean().sqrt()),
        "r2_log": float(1 - error.square().mean() / wanted.var(unbiased=False)),
        "nees": float(nees.mean()),
    }


def pair_loss(told: Tensor, truth: Examples) -> Tensor:
    """Of the offset (likelihood, and distribution over shifts) on the same ground, and of which
    pairs are."""
    same, offset = truth["same"].float(), truth["offset"].float()
    log_sigma = told[:, 1].clamp(-6, 1)
    apart = ((told[:, 0] - offset) * torch.exp(-log_sigma)).abs()
    # Huber: a wrong peak must not widen all others.
    error = torch.where(apart < 3, 0.5 * apart.square(), 3 * apart - 4.5) + log_sigma
    shifts = torch.arange(told.shape[1] - 3) - (told.shape[1] - 4) / 2
    target = torch.softmax(-0.5 * (shifts - offset[:, None] / COLUMN).square(), 1)
    cross = -(target * torch.log_softmax(told[:, 3:], 1)).sum(1)
    on_ground = (same * (0.3 * error + cross)).sum() / same.sum().clamp(min=1)
    return on_ground + functional.binary_cross_entropy_with_logits(told[:, 2], same)


def judge_pairs(told: Tensor, truth: Examples) -> dict[str, Any]:
    """Error and NEES of accepted pairs, and the chance from which on `RIGHT` of them are right."""
    same, offset = truth["same"] > 0.5, truth["offset"].float()
    chance = torch.sigmoid(told[:, 2])
    error = told[:, 0] - offset
    best: dict[str, Any] = {"accept": 1.0, "recall": 0.0, "rms_m": None, "nees": None}
    for limit in sorted(SAME_AT, reverse=True):
        taken = chance > limit
        found = float((taken & same).sum() / same.sum())
        wrong = float((taken & ~same).sum() / (~same).sum())
        if found == 0:
            continue
        if found * PRIOR / (found * PRIOR + wrong * (1 - PRIOR)) < RIGHT:
            break
        good = taken & same
        close = error[good].abs() < 0.1
        best = {
            "accept": limit,
            "recall": found,
            "rms_m": float(error[good][close].square().mean().sqrt()),
            "close": float(close.float().mean()),
            "nees": float((error[good] * torch.exp(-told[good, 1])).square().clamp(max=25).mean()),
        }
    best["median_m"] = float(error[same].abs().median())
    return best


TASKS = (
    Task("learned_sequential", SequentialNet, ("before", "after"), spacing_loss, judge_spacing),
    Task("learned_pair", PairNet, ("memory", "query"), pair_loss, judge_pairs),
)
_TRUTH = {"learned_sequential": ("spacing",), "learned_pair": ("offset", "same")}


def evaluate(network: nn.Module, task: Task, examples: Examples) -> Tensor:
    """What the network says of all examples."""
    network.eval()
    first, second = (examples[name] for name in task.inputs)
    with torch.no_grad():
        parts = [
            network(first[i : i + 256].float(), second[i : i + 256].float())
            for i in range(0, len(first), 256)
        ]
    return torch.cat(parts)


def train(
    task: Task, part: dict[str, Examples], folder: Path, seed: int, epochs: int, shown: float
) -> dict[str, Any]:
    """Trains one network; returns its record. `shown`: of all progress, what is done already."""
    torch.manual_seed(seed)
    network = task.make()
    count = len(part["train"][task.inputs[0]])
    batches = max(count // BATCH, 1)
    optimiser = torch.optim.AdamW(network.parameters(), lr=RATE, weight_decay=1e-3)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, RATE, total_steps=epochs * batches)
    kept = folder / f"{task.name}.pt"
    begun, history = 0, []
    if kept.exists():
        state = torch.load(kept)
        if (state["seed"], state["epochs"], state["count"]) == (seed, epochs, count):
            network.load_state_dict(state["network"])
            optimiser.load_state_dict(state["optimiser"])
            schedule.load_state_dict(state["schedule"])
            begun, history = state["epoch"], state["history"]
    for epoch in range(begun, epochs):
        order = torch.randperm(count, generator=torch.Generator().manual_seed(seed + epoch))
        network.train()
        total = 0.0
        for batch in range(batches):
            chosen = order[batch * BATCH : (batch + 1) * BATCH]
            some = {name: values[chosen] for name, values in part["train"].items()}
            optimiser.zero_grad()
            loss = task.loss(network(*(some[name].float() for name in task.inputs)), some)
            loss.backward()
            nn.utils.clip_grad_norm_(network.parameters(), 1.0)
            optimiser.step()
            schedule.step()
            total += float(loss.detach())
            if batch % 20 == 0:
                share = shown + (epoch + batch / batches) / epochs / len(TASKS)
                print(f"progress {share:.4f} {task.name}", flush=True)
        figures = task.judge(evaluate(network, task, part["validate"]), part["validate"])
        history.append({"loss": total / batches, **figures})
        torch.save(
            {
                "network": network.state_dict(), "optimiser": optimiser.state_dict(),
                "schedule": schedule.state_dict(), "epoch": epoch + 1, "history": history,
                "seed": seed, "epochs": epochs, "count": count,
            },
            kept,
        )  # fmt: skip
    export(network, task, part["validate"], folder)
    weights = sum(values.numel() for values in network.parameters())
    return {"weights": weights, "examples": count, "history": history, **history[-1]}


def export(network: nn.Module, task: Task, examples: Examples, folder: Path) -> None:
    """NETWORK.onnx, and NETWORK.npz with some inputs and what PyTorch says of them."""
    network.eval()
    some = tuple(examples[name][:64].float() for name in task.inputs)
    torch.onnx.export(
        network,
        some,
        str(folder / f"{task.name}.onnx"),
        input_names=list(task.inputs),
        output_names=["told"],
        dynamic_axes={name: {0: "n"} for name in (*task.inputs, "told")},
        opset_version=13,
    )
    with torch.no_grad():
        told = network(*some).numpy()
    inputs = {name: x.numpy() for name, x in zip(task.inputs, some, strict=True)}
    np.savez_compressed(folder / f"{task.name}.npz", told=told, **inputs)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("train", type=Path)
    parser.add_argument("validate", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--epochs", type=int, required=True)
    parser.add_argument("--threads", type=int, default=1)
    args = parser.parse_args()
    torch.set_num_threads(args.threads)
    torch.use_deterministic_algorithms(True)
    record: dict[str, Any] = {"torch": torch.__version__, "seed": args.seed, "epochs": args.epochs}
    started = time.monotonic()
    for done, task in enumerate(TASKS):
        names = (*task.inputs, *_TRUTH[task.name])
        part = {"train": read_examples(args.train, names)}
        part["validate"] = read_examples(args.validate, names)
        shown = done / len(TASKS)
        record[task.name] = train(task, part, args.folder, args.seed, args.epochs, shown)
    record["training_s"] = round(time.monotonic() - started, 1)
    text = json.dumps(record, indent=2)
    (args.folder / "training.json").write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
