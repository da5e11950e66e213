"""gprodom report: what it says of a drive whose troubles are known, and its page in a browser."""

from __future__ import annotations

import json
import re
from pathlib import Path

import justhtml
import numpy as np
import pytest

from browser import printed_pages, show
from gprodom import canvas
from gprodom.cli import main
from gprodom.config import STANDARD
from gprodom.drive.log import read_drive
from gprodom.drive.radargram import along_way
from gprodom.drive.troubles import Trouble, covered_s, find_troubles
from gprodom.lcm import EventLog, logs
from gprodom.lcm.log_scan import events
from gprodom.report import vector
from gprodom.report.page import verdict
from made_drive import (
    DEGRADED_S,
    RADIUS,
    SECONDS,
    SILENT_S,
    SLIPS_S,
    SPEED,
    STANDS_S,
    spread,
    write_drive,
)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("drive") / "recording.lcmlog"
    write_drive(path)
    return path


@pytest.fixture(scope="module")
def page(recording: Path) -> Path:
    path = recording.with_name("drive.html")
    assert main(["report", str(recording), "-o", str(path)]) == 0
    return path


def test_troubles_are_told_with_their_times(recording: Path) -> None:
    found = {each.what: each for each in find_troubles(read_drive(recording, STANDARD))}

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


def test_figures_of_the_drive(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = recording.with_name("figures.html")
    assert main(["report", str(recording), "-o", str(out), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    driven = SPEED * (SECONDS - STANDS_S)
    assert facts["distance_m"] == pytest.approx(driven, abs=0.05)
    turned = driven / RADIUS
    expected = [RADIUS * np.sin(turned), RADIUS * (1 - np.cos(turned))]
    assert facts["end_m"] == pytest.approx(expected, abs=0.1)
    # 95 % of a normal distribution in the plane lie within 2.448 standard deviations.
    largest = np.linalg.eigvalsh(spread(SECONDS))[1]
    assert facts["end_radius_95_m"] == pytest.approx(2.448 * np.sqrt(largest), rel=0.01)
    assert facts["revisits"] == 2
    assert facts["slipping_s"] == pytest.approx(sum(end - begin for begin, end in SLIPS_S), abs=0.2)
    assert facts["dead_reckoning_end_m"] < 0.3  # the made-up wheel and gyro are right
    assert facts["troubles"] == 2


def test_sensors_come_from_the_input_of_a_replay(recording: Path, tmp_path: Path) -> None:
    output, pages = tmp_path / "out.lcmlog", []
    write_drive(output, sensors=False)
    for more in ([], ["--sensors", str(recording)]):
        made = tmp_path / f"{len(more)}.html"
        assert main(["report", str(output), "-o", str(made), *more]) == 0
        pages.append(made.read_text())
    assert "The ground" not in pages[0] and "The ground" in pages[1]
    assert "wheel and gyro alone" not in pages[0] and "wheel and gyro alone" in pages[1]


def test_a_log_without_an_estimate_is_refused_with_what_to_do(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = EventLog(str(tmp_path / "in.lcmlog"), "w")
    log.write_event(1, "IMU", b"12345678")
    log.close()
    assert main(["report", str(tmp_path / "in.lcmlog"), "-o", str(tmp_path / "a.html")]) == 1
    assert "gprodom-replay -c CONFIG" in capsys.readouterr().err
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


def test_a_figure_in_a_page_takes_its_colours_and_is_named() -> None:
    drawn = []
    for name in ("one", "two"):
        figure, (axis,) = canvas.new_figure()
        axis.plot([0, 1], [0, 1], "o")
        axis.set_title("<a title>")
        drawn.append(vector.inline(figure, name, 'of "one"'))
    assert all(vector.INK not in each and "currentColor" in each for each in drawn)
    assert 'aria-label="of &quot;one&quot;"' in drawn[0]
    ids = [set(re.findall(r'\sid="([^"]+)"', each)) for each in drawn]
    assert ids[0] and not ids[0] & ids[1]
    justhtml.JustHTML(canvas.page("figures", drawn), strict=True)


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


def test_radargram_has_a_column_for_each_piece_of_the_way(recording: Path) -> None:
    """However long the robot stood there: the ground depends on the place alone."""
    drive = read_drive(recording, STANDARD)
    odometry = drive.log["odometry"]
    image = along_way(drive.sensors["gpr_trace"], odometry["utime"], odometry["distance"], 200)
    assert image.length_m == pytest.approx(SPEED * (SECONDS - STANDS_S), abs=0.05)
    assert image.span_ns == pytest.approx((0.0, 20.2))
    metres = (np.arange(200) + 0.5) * image.length_m / 200
    expected = np.sin(0.3 * 50 + 3 * metres)
    known = np.isfinite(image.echoes[50])
    assert known.mean() > 0.95
    assert np.corrcoef(image.echoes[50][known], expected[known])[0, 1] > 0.97


def test_events_of_a_log_are_those_of_lcms_own_reader(recording: Path, tmp_path: Path) -> None:
    whole = [(e.channel, e.timestamp, e.data) for e in EventLog(str(recording), "r")]
    assert list(events(recording)) == whole
    assert list(events(recording, ["STATUS"])) == [e for e in whole if e[0] == "STATUS"]
    content = recording.read_bytes()[:200_000]
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


def test_a_thinned_log_has_one_message_in_each_period(recording: Path) -> None:
    every = logs.read(recording, ["ODOMETRY"], every_us={"ODOMETRY": 1_000_000})["ODOMETRY"][
        "utime"
    ]
    steps = np.diff(every)
    assert steps.min() >= 1_000_000 and len(every) == SECONDS - 2  # and those of the silence
