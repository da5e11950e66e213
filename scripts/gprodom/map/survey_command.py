"""``gprodom map survey``: surveyed markers as fixes, and how far an estimate is from them."""

import argparse

from gprodom import canvas
from gprodom.config import read_antennas, read_channels, read_datum
from gprodom.console import format_table, tell, warn
from gprodom.errors import UsageError
from gprodom.export.command import parse_datum
from gprodom.files import OutputFile, PictureFile
from gprodom.fixes.made import add_to_log
from gprodom.fixes.markers import as_fixes, read_markers
from gprodom.fixes.record import one_stream
from gprodom.fixes.site import datum_of_log
from gprodom.geodesy import Datum
from gprodom.map.survey import compare, in_site, survey_figure
from gprodom.options import Subparsers, add_command
from gprodom.score.sources import read_estimate

DESCRIPTION = """\
Takes points of known position over which the robot stood with an antenna (or a mark on it, whose
place in body is in anchor.antennas). MARKERS is a CSV with a line of names:

  name, x, y, z, sigma, from, to                        m, in site; or
  name, latitude, longitude, height, sigma, from, to    degrees and m
  antenna                                               its id (0 where there is no such column)

from and to are the times between which the robot stood there: seconds since 1970, or a date such as
2026-05-12T10:30:00 (UTC). A marker that was visited twice has two lines.

  --fixes    writes a copy of LOG with a fix of quality `surveyed` for each visit, in its middle:
             its estimate is then tied to the markers
  otherwise  LOG has an estimate: prints how far it is from each marker (estimate less marker; mean
             over the visit), and --picture draws it. It is compared in site, as a map is that
             fixes have tied; --align se2 turns and moves it first, for one that is not

examples:
  gprodom map survey markers.csv drive.lcmlog --fixes tied.lcmlog
  gprodom run tied.lcmlog --method gprodom_full -o out.lcmlog
  gprodom map survey markers.csv out.lcmlog --picture residuals.png
"""


def add_survey(works: Subparsers) -> None:
    """Adds ``map survey``."""
    parser = add_command(works, "survey", "surveyed markers", DESCRIPTION, run)
    parser.operand("markers", "MARKERS", "CSV, see above")
    parser.operand("log", "LOG", "LCM log")
    parser.option("--fixes OUT", OutputFile, "log with fixes to write")
    parser.option("--picture FILE", PictureFile, "picture to draw")
    parser.choice("--align", ["none", "se2"], "none", "default: %(default)s")
    parser.option(
        "--datum LAT,LON[,HEIGHT]",
        parse_datum,
        "where site lies, for markers in degrees (default: what LOG or anchor.datum tells)",
    )
    parser.common_options()


def run(args: argparse.Namespace) -> int:
    """Adds fixes, or prints residuals."""
    markers = read_markers(args.markers)
    channels = read_channels(args.configs, args.overrides)
    if args.fixes is not None:
        if args.picture is not None:
            raise UsageError("--picture wants an estimate, which --fixes prepares")
        add_to_log(args.log, args.fixes, [one_stream(channels.position_fix, as_fixes(markers))])
        told = {"log": str(args.fixes), "fixes": len(markers)}
        names = {marker.name for marker in markers}
        tell(args.json, told, f"{args.fixes}: {len(markers)} fixes of {len(names)} markers")
        return 0
    configured = read_datum(args.configs, args.overrides)
    datum: Datum | None = args.datum or datum_of_log(args.log, channels, configured)
    if datum is None and configured is not None:
        datum = Datum(*configured)
    antennas = read_antennas(args.configs, args.overrides, "anchor.antennas")
    path = read_estimate(args.log, channels=channels).trajectory
    found = compare(path, markers, in_site(markers, datum), antennas, args.align == "se2")
    if found.uncovered:
        warn(f"not visited while there was an estimate: {', '.join(found.uncovered)}")
    if args.picture is not None:
        canvas.save(survey_figure(found), args.picture)
    rows = [[r.name, r.x_m, r.y_m, r.off_m, r.sigma_m] for r in found.residuals]
    table = format_table(["marker", "x (m)", "y (m)", "off (m)", "sigma (m)"], rows)
    tell(args.json, found.facts(), f"{table}\nRMS {found.rms_m:.3f} m over {len(rows)} visits")
    return 0
