"""The two networks, in PyTorch. Inputs are as `windows` makes them; all normalisation is inside, of
each input by itself, so that no statistic of a data set is kept."""

import math

import torch
from torch import Tensor, nn
from torch.nn import functional

from gprodom.learned.windows import COLUMN, COLUMNS, ROWS

LEAST_SPACING = 1e-3  # m; the logarithm of the spacing is taken of it and this together
_BANDS = 4  # of rows, in which features are pooled
_SHIFTS = COLUMNS // 2  # columns, by which images are shifted to either side


def _envelope(x: Tensor, rows: int) -> Tensor:
    """RMS over the columns and about `rows` rows, of (n, 1, ROWS, columns)."""
    power = functional.avg_pool2d(x.square().mean(3, keepdim=True), (rows, 1), 1, (rows // 2, 0))
    return torch.sqrt(power + 1e-12)


class SequentialNet(nn.Module):
    """learned_sequential: the way from trace to trace, of two consecutive windows.

    A siamese encoder; features of three scales of either window and their differences are pooled
    in bands of depth and regressed, as GPR-OdomNet does it. Returns (n, 2): the mean of
    ln(spacing + LEAST_SPACING) and the logarithm of its standard deviation.
    """

    def __init__(self) -> None:
        super().__init__()
        self.stages = nn.ModuleList([
            nn.Conv2d(2, 16, (5, 3), (2, 1), (2, 1)),
            nn.Conv2d(16, 24, 3, (2, 2), 1),
            nn.Conv2d(24, 32, 3, (2, 2), 1),
        ])  # fmt: skip
        self.head = nn.Sequential(
            nn.Linear(3 * _BANDS * (16 + 24 + 32), 64), nn.ReLU(), nn.Linear(64, 2)
        )

    def forward(self, before: Tensor, after: Tensor) -> Tensor:
        """before, after: (n, WINDOW, ROWS)."""
        a, b = (x.transpose(1, 2).unsqueeze(1) for x in (before, after))
        both = torch.cat([a, b], 3)
        envelope = _envelope(both, 9)
        mean = both.mean(3, keepdim=True)
        change = both - mean
        own = torch.sqrt(_envelope(change, 9).square() + (2e-3 * envelope).square())

        def channels(x: Tensor) -> Tensor:
            of_mean = torch.tanh((x - mean) / (0.3 * envelope))
            return torch.cat([of_mean, torch.tanh((x - mean) / (2 * own))], 1)

        fa, fb = channels(a), channels(b)
        pooled = []
        rows = ROWS
        for stage in self.stages:
            fa, fb = functional.relu(stage(fa)), functional.relu(stage(fb))
            rows //= 2
            for f in (fa, fb, (fa - fb).abs()):
                bands = f.mean(3).reshape(-1, stage.out_channels * _BANDS, rows // _BANDS)
                pooled.append(bands.mean(2))
        return self.head(torch.log(torch.cat(pooled, 1) + 1e-3))


class PairNet(nn.Module):
    """learned_pair: where an image lies along another one, and whether on the same ground.

    Both are encoded, all columns of one are correlated with all of the other, and the mean
    similarity at each shift gives the distribution of the offset. Returns (n, 3 + shifts): offset
    (m), the logarithm of its standard deviation (m), the log-odds of the same ground; then the
    logits of the shifts, for training.
    """

    def __init__(self) -> None:
        super().__init__()
        self.encoder = nn.Sequential(
            nn.Conv2d(1, 12, (7, 5), (4, 1), (3, 2)),
            nn.ReLU(),
            nn.Conv2d(12, 16, 3, (2, 1), 1),
            nn.ReLU(),
            nn.Conv2d(16, 16, 3, (2, 1), 1),
        )
        self.curve = nn.Sequential(nn.Conv1d(1, 8, 5, 1, 2), nn.ReLU(), nn.Conv1d(8, 1, 5, 1, 2))
        self.same = nn.Sequential(nn.Linear(6, 16), nn.ReLU(), nn.Linear(16, 1))
        self.spread = nn.Sequential(nn.Linear(6, 16), nn.ReLU(), nn.Linear(16, 1))
        self.sharpness = nn.Parameter(torch.tensor(15.0))
        shifts = torch.arange(-_SHIFTS, _SHIFTS + 1).float()
        self.register_buffer("shifts", shifts)
        self.register_buffer("shared_columns", COLUMNS - shifts.abs())

    def _encode(self, picture: Tensor) -> Tensor:
        x = picture.unsqueeze(1)
        x = x - x.mean(3, keepdim=True)
        f = self.encoder(torch.tanh(x / (2 * _envelope(x, 9))))
        f = f.flatten(1, 2)  # (n, features, columns)
        f = f - f.mean(2, keepdim=True)
        return f / torch.sqrt(f.square().sum(1, keepdim=True).mean(2, keepdim=True) + 1e-9)

    def forward(self, memory: Tensor, query: Tensor) -> Tensor:
        """memory, query: (n, ROWS, COLUMNS)."""
        similar = torch.matmul(self._encode(query).transpose(1, 2).flip(1), self._encode(memory))
        # Row i (from the query's last column on) moved on by i: a column is then a shift.
        skewed = functional.pad(similar, (0, COLUMNS)).flatten(1)[:, :-COLUMNS]
        sums = skewed.reshape(-1, COLUMNS, 2 * COLUMNS - 1).sum(1)
        middle = sums[:, COLUMNS - 1 - _SHIFTS : COLUMNS + _SHIFTS]
        curve = middle / self.shared_columns
        logits = (self.sharpness * curve).unsqueeze(1)
        logits = (logits + self.curve(curve.unsqueeze(1))).squeeze(1)
        chance = torch.softmax(logits, 1)
        offset = (chance * self.shifts).sum(1, keepdim=True)
        variance = (chance * (self.shifts - offset).square()).sum(1, keepdim=True)
        best = curve.max(1, keepdim=True).values
        told = torch.cat(
            [
                best,
                curve.mean(1, keepdim=True),
                curve.std(1, keepdim=True),
                (chance * curve).sum(1, keepdim=True),
                (chance * torch.log(chance + 1e-9)).sum(1, keepdim=True),
                torch.log(variance + 0.25),
            ],
            1,
        )
        spread = 0.5 * torch.log(variance + 0.25) + self.spread(told)
        return torch.cat([COLUMN * offset, spread + math.log(COLUMN), self.same(told), logits], 1)
