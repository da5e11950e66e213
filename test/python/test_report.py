"""gprodom report: what it says of a drive whose troubles are known, and its page in a browser."""

import re
from pathlib import Path

import justhtml
import numpy as np
import pytest

from browser import printed_pages, show
from conftest import Cli, run_cli
from gprodom.config import STANDARD
from gprodom.drive.log import read_drive
from gprodom.drive.radargram import along_way
from gprodom.drive.troubles import Trouble, covered_s, find_troubles
from gprodom.lcm import EventLog, logs
from gprodom.lcm.log_scan import events
from gprodom.report.page import verdict
from made_drive import DEGRADED_S, SECONDS, SILENT_S, SLIPS_S, along, place, spread, write_drive
from packets import write_events


@pytest.fixture(scope="module")
def page(made_log: Path) -> Path:
    path = made_log.with_name("drive.html")
    run_cli("report", made_log, "-o", path)
    return path


def test_troubles_are_told_with_their_times(made_log: Path) -> None:
    found = {each.what: each for each in find_troubles(read_drive(made_log, STANDARD))}

    def near(trouble: Trouble, spans: list[tuple[float, float]], slack: float) -> None:
        assert np.allclose(np.array(trouble.spans), np.array(spans), atol=slack), trouble

    silence = found.pop("no pose was published")
    near(silence, [(SILENT_S[0], SILENT_S[1] - SILENT_S[0])], 0.1)
    assert silence.level == "failed"
    slip = found.pop("the wheel slips: it is faster than the ground (spins)")
    near(slip, [(begin, end - begin) for begin, end in SLIPS_S], 0.1)
    # Its figure changes from second to second: it is one reason, told once.
    radar = found.pop(f"GPR_TRACE: no data for {DEGRADED_S[0]:.1f} s or more")
    near(radar, [(DEGRADED_S[0], DEGRADED_S[1] - DEGRADED_S[0])], 0.1)
    assert radar.level == "degraded"
    # Told while degraded and while all was well: it is no trouble of its own.
    assert found.pop("map: searching for earlier ground").level == "note"
    spikes = found.pop("GPR_TRACE: trace with a spike")
    assert (spikes.times, spikes.level) == (3, "note")
    near(spikes, [(29.0, 1.0), (49.0, 1.0)], 0.1)
    assert not found


def test_troubles_at_the_same_time_last_as_long_as_one() -> None:
    spans = {"a": ((0.0, 10.0), (40.0, 5.0)), "b": ((5.0, 10.0),), "c": ((6.0, 1.0),)}
    worse = [Trouble(name, "degraded", each) for name, each in spans.items()]
    assert covered_s(worse) == 20.0
    assert verdict(worse) == "3 things, 20 s altogether"
    assert verdict([]) == "nothing"


def test_figures_of_the_drive(made_log: Path, cli: Cli) -> None:
    facts = cli.json("report", made_log, "-o", made_log.with_name("figures.html"))
    assert facts["distance_m"] == pytest.approx(along(SECONDS), abs=0.05)
    assert facts["end_m"] == pytest.approx(place(SECONDS), abs=0.1)
    # 95 % of a normal distribution in the plane lie within 2.448 standard deviations.
    largest = np.linalg.eigvalsh(spread(SECONDS))[1]
    assert facts["end_radius_95_m"] == pytest.approx(2.448 * np.sqrt(largest), rel=0.01)
    assert facts["revisits"] == 2
    assert facts["slipping_s"] == pytest.approx(sum(end - begin for begin, end in SLIPS_S), abs=0.2)
    assert facts["dead_reckoning_end_m"] < 0.3  # the made-up wheel and gyro are right
    assert facts["troubles"] == 2


def test_sensors_come_from_the_input_of_a_replay(made_log: Path, tmp_path: Path) -> None:
    output, pages = tmp_path / "out.lcmlog", []
    write_drive(output, sensors=False)
    for more in ([], ["--sensors", str(made_log)]):
        made = tmp_path / f"{len(more)}.html"
        run_cli("report", output, "-o", made, *more)
        pages.append(made.read_text())
    assert "The ground" not in pages[0] and "The ground" in pages[1]
    assert "wheel and gyro alone" not in pages[0] and "wheel and gyro alone" in pages[1]


def test_a_log_without_an_estimate_is_refused_with_what_to_do(tmp_path: Path, cli: Cli) -> None:
    write_events(tmp_path / "in.lcmlog", [(1, "IMU", b"12345678")])
    assert "gprodom-replay -c CONFIG" in cli.error(
        "report", tmp_path / "in.lcmlog", "-o", tmp_path / "a.html"
    )
    assert not (tmp_path / "a.html").exists()


def test_page_is_valid_html_that_fetches_nothing(page: Path) -> None:
    text = page.read_text()
    tree = justhtml.JustHTML(text, strict=True, sanitize=False)  # raises on an error
    assert len(tree.query("svg.figure")) == 8
    assert all("d" in path.attrs for path in tree.query("path"))
    identifiers = re.findall(r'\sid="([^"]+)"', text)
    assert len(identifiers) == len(set(identifiers)) > 10
    named = set(re.findall(r'(?:href="#|url\(#)([^")]+)', text))
    assert named == set(identifiers)
    fetched = re.findall(r'(?:src|href)="(?!#|data:)[^"]*"|url\((?!#)[^)]*\)|@import', text)
    assert not fetched and "<script" not in text


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_page_in_a_browser(page: Path, scheme: str, tmp_path: Path) -> None:
    """Nothing cut from a phone's width to that of a large screen, and no complaint."""
    widths = [360, 480, 768, 1024, 1366, 1920]
    shown = show(page, widths, scheme, tmp_path)
    assert not shown.console
    assert [frame["width"] for frame in shown.frames] == widths
    for frame in shown.frames:
        assert not frame["cut"], frame
        assert len(frame["figures"]) == 4, "of the wide and the narrow pictures one each"
        assert frame["contrast"] >= 4.5, frame  # WCAG AA for text
    dark = shown.frames[0]
    light_of_paper = sum(map(int, re.findall(r"\d+", dark["paper"])[:3]))
    light_of_ink = sum(map(int, re.findall(r"\d+", dark["ink"])[:3]))
    assert (light_of_ink > light_of_paper) == (scheme == "dark")


def test_a_browser_finds_what_is_cut(tmp_path: Path) -> None:
    """The measurement itself: a line that does not fit, a pale text, a script that fails."""
    bad = tmp_path / "bad.html"
    bad.write_text(
        "<!doctype html><style>body{background:#fff;margin:0}</style><script>nothing()</script>"
        '<div style="width:700px">wide</div><p style="color:#ccc">pale</p>'
    )
    shown = show(bad, [360], "light", tmp_path)
    assert any("DIV" in each for each in shown.frames[0]["cut"])
    assert shown.frames[0]["contrast"] < 2
    assert any("nothing is not defined" in each for each in shown.console)


def test_page_prints_on_four_sheets(page: Path, tmp_path: Path) -> None:
    assert printed_pages(page, tmp_path) <= 4


def test_radargram_has_a_column_for_each_piece_of_the_way(made_log: Path) -> None:
    """However long the robot stood there: the ground depends on the place alone."""
    drive = read_drive(made_log, STANDARD)
    odometry = drive.log["odometry"]
    image = along_way(drive.sensors["gpr_trace"], odometry["utime"], odometry["distance"], 200)
    assert image.length_m == pytest.approx(along(SECONDS), abs=0.05)
    assert image.span_ns == pytest.approx((0.0, 20.2))
    metres = (np.arange(200) + 0.5) * image.length_m / 200
    expected = np.sin(0.3 * 50 + 3 * metres)
    known = np.isfinite(image.echoes[50])
    assert known.mean() > 0.95
    assert np.corrcoef(image.echoes[50][known], expected[known])[0, 1] > 0.97


def test_events_of_a_log_are_those_of_lcms_own_reader(made_log: Path, tmp_path: Path) -> None:
    whole = [(e.channel, e.timestamp, e.data) for e in EventLog(str(made_log), "r")]
    assert list(events(made_log)) == whole
    assert list(events(made_log, ["STATUS"])) == [e for e in whole if e[0] == "STATUS"]
    content = made_log.read_bytes()[:200_000]
    random = np.random.default_rng(1)
    for _ in range(40):  # damaged, or cut out
        damaged = np.frombuffer(content, np.uint8).copy()
        at = random.integers(0, len(damaged), 3)
        damaged[at] = random.integers(0, 256, 3)
        path = tmp_path / "damaged.lcmlog"
        path.write_bytes(damaged[random.integers(0, 500) : random.integers(1000, 200_000)])
        try:
            theirs = [(e.channel, e.timestamp, e.data) for e in EventLog(str(path), "r")]
        except UnicodeDecodeError:  # the name of a channel was hit
            continue
        assert list(events(path)) == theirs


def test_a_thinned_log_has_one_message_in_each_period(made_log: Path) -> None:
    every = logs.read(made_log, ["ODOMETRY"], every_us={"ODOMETRY": 1_000_000})["ODOMETRY"]["utime"]
    steps = np.diff(every)
    assert steps.min() >= 1_000_000 and len(every) == SECONDS - 2  # and those of the silence
