"""Options of all commands."""

import pytest

from conftest import Cli
from gprodom.cli import build_parser


@pytest.mark.parametrize(
    ("line", "name", "value"),
    [
        ("score a b --prism -0.1,0,0", "prism", (-0.1, 0.0, 0.0)),
        ("score --prism -.1,-2,-3 a b", "prism", (-0.1, -2.0, -3.0)),
        ("map cut a --area -10,-5,3,3 -o b", "area", (-10.0, -5.0, 3.0, 3.0)),
        ("map cut a --area=-10,-5,3,3 -o b", "area", (-10.0, -5.0, 3.0, 3.0)),
        ("calibrate wheel a --prism -0.1,0", "prism", (-0.1, 0.0)),
        ("score a b --first-m -1e-3", "first_m", -1e-3),
    ],
)
def test_a_value_may_begin_with_a_minus(line: str, name: str, value: object) -> None:
    assert getattr(build_parser().parse_args(line.split()), name) == value


def test_a_datum_south_of_the_equator() -> None:
    line = "export out.lcmlog --datum -33.9,18.4,40 --csv path.csv"
    datum = build_parser().parse_args(line.split()).datum
    assert (datum.latitude, datum.longitude, datum.height) == (-33.9, 18.4, 40.0)


def test_flags_and_what_follows_two_dashes_stay(cli: Cli) -> None:
    args = build_parser().parse_args(["score", "--json", "--plot", "out", "--", "a", "b"])
    assert (args.json, str(args.plot), str(args.truth)) == (True, "out", "b")
    said = cli.error("score", "a", "b", "--prism", "--json", code=2)
    assert "expected one argument" in said
