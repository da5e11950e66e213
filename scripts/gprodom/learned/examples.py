"""Examples to train on: windows and images of passes over simulated grounds, with the truth."""

from collections.abc import Callable

import numpy as np

from gprodom.arrays import Floats
from gprodom.learned import windows
from gprodom.learned.grounds import Line, draw_any_radar, draw_rate, draw_speed, make_line, receive
from gprodom.learned.windows import WINDOW, image, to_rows
from gprodom.random_streams import Random, stream

PASSES = 32  # over each ground
STEPS = 12  # examples of a pass by windows
PAIRS = 10  # examples of a pass by images
_STANDING = 0.1  # share of the passes that stand
_SAME = 0.5  # share of the pairs on the same ground
REACH = 0.6  # m, of offsets between images on the same ground
_SCALE = 0.03  # of the track that the images are laid along, standard deviation

Examples = dict[str, Floats]


def make_examples(grounds: list[tuple[int, str]], on_ground: Callable[[], None]) -> Examples:
    """All examples of the grounds (see `make_line`): arrays by name."""
    made: list[Examples] = []
    for seed, kept in grounds:
        line, random = make_line(seed, kept), stream(seed, f"learned examples {kept}".strip())
        passes = [_by_windows(line, random) for _ in range(PASSES)]
        passes += [_by_images(line, random) for _ in range(PASSES)]
        made.append(joined(passes))
        on_ground()
    return joined(made)


def joined(parts: list[Examples]) -> Examples:
    """The arrays of each name, one after the other; a part need not have all."""
    names = dict.fromkeys(name for each in parts for name in each)
    return {name: np.concatenate([x[name] for x in parts if name in x]) for name in names}


def _by_windows(line: Line, random: Random) -> Examples:
    """Two consecutive windows, and the mean way from trace to trace between their ends (m)."""
    rate = draw_rate(random)
    # A pass at the driver's rate, or at a step that the rule would not give: counts say nothing.
    step = int(np.clip(round(windows.step_at(rate) * random.uniform(0.7, 1.4)), 4, WINDOW))
    speed = 0.0 if random.uniform() < _STANDING else draw_speed(random)
    traces = WINDOW + STEPS * step
    time = np.arange(traces) / rate
    wave = 0.3 * random.uniform() * np.sin(time * random.uniform(0.3, 2.0) + random.uniform(0, 6))
    way = np.concatenate([[0.0], np.cumsum((speed * (1 + wave))[1:] / rate)])
    way *= min(1.0, 0.95 * line.length / max(way[-1], 1e-9))
    along = random.uniform(0, line.length - way[-1]) + way
    if random.uniform() < 0.5:
        along = along[::-1]
    rows = to_rows(receive(line, along, rate, random, 0, draw_any_radar), line.sample_interval)
    ends = WINDOW + step * np.arange(1, STEPS + 1)
    return {
        "before": np.array([rows[end - step - WINDOW : end - step] for end in ends], np.float16),
        "after": np.array([rows[end - WINDOW : end] for end in ends], np.float16),
        "spacing": np.array([(way[end - 1] - way[end - 1 - step]) / step for end in ends]),
        "step": np.full(STEPS, step),
    }


def _by_images(line: Line, random: Random) -> Examples:
    """Images of two passes, both laid along the first one's direction; where the second one lies
    from the first (m) and whether on the same ground (1) or not (0)."""
    scale = 1 + _SCALE * random.standard_normal()
    memory_pass = _pass(line, random, scale, 0)
    query_pass = _pass(line, random, scale, int(random.uniform() < 0.8))
    room = line.length - 1.2 * windows.LENGTH - REACH
    here = random.uniform(REACH, room, PAIRS)
    same = random.uniform(size=PAIRS) < _SAME
    offset = np.where(same, random.uniform(-REACH, REACH, PAIRS), 0.0)
    there = np.array(
        [h if s else _elsewhere(h, room, random) for h, s in zip(here, same, strict=True)]
    )

    def images(of: tuple[Floats, Floats], places: Floats) -> Floats:
        # Laid round the middle, where the error of the scale leaves it.
        starts = scale * (places + windows.LENGTH / 2) - windows.LENGTH / 2
        return np.array([image(*of, start) for start in starts], np.float16)

    return {
        "memory": images(memory_pass, here),
        "query": images(query_pass, there + offset),
        "offset": offset,
        "same": same.astype(float),
    }


def _elsewhere(here: float, room: float, random: Random) -> float:
    while True:
        there = random.uniform(REACH, room)
        if abs(there - here) > windows.LENGTH:
            return float(there)


def _pass(line: Line, random: Random, scale: float, on: int) -> tuple[Floats, Floats]:
    """Rows of a pass over the whole ground, and their places as the track has them (m)."""
    rate, speed = draw_rate(random), draw_speed(random)
    spacing = min(speed / rate, 0.06)  # wider ones show no image
    along = np.arange(0.0, line.length, max(spacing, 0.005))
    rows = to_rows(receive(line, along, rate, random, on, draw_any_radar), line.sample_interval)
    return rows, scale * along
