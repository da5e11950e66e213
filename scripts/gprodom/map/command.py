"""``gprodom map``: map files."""

import argparse
from pathlib import Path
from typing import Any

import numpy as np

from gprodom import canvas
from gprodom.console import add_json_flag, format_table, tell
from gprodom.errors import Error, UsageError
from gprodom.export.command import parse_datum
from gprodom.export.paths import write_csv, write_geojson
from gprodom.files import Output, OutputFile, OutputFolder, write_bytes
from gprodom.geodesy import Datum
from gprodom.map import cut, service
from gprodom.map import merge as merging
from gprodom.map.ground import MapFile, facts, read_map
from gprodom.map.picture import map_figure
from gprodom.map.site import datum_of, site_as_text
from gprodom.map.survey_command import add_survey
from gprodom.options import Parser, Subparsers, add_command
from gprodom.trajectory import joined

DESCRIPTION = """\
Works on map files: the ground driven over with the poses along it, as gprodomd leaves it in
state.directory (ground.map, and NAME.map by the command save_map). A file is checked entirely
before anything of it is used. Its format: docs/map_format.md.
"""

INFO = """\
Prints what is in map files. What the file's version does not hold reads `not in this version`. Its
sessions are the drives that the ground comes from. The maps of a file are tracks that were never
tied to each other: their frames are not related, unless fixes have tied them to site.
"""

PLOT = """\
Draws the paths of a map and, as a band, the ground that is stored along them: on ground that was
driven over twice the second pass is not stored again.
"""

EXPORT = """\
Writes the paths of a map, with the writers of `gprodom export`:

  --geojson  a line of longitude, latitude and height for each path; needs a datum and pyproj
  --csv      a row for each known pose; with a datum latitude, longitude and height, too

The datum is the position of the map's origin, in degrees and metres, and the angle from east to
its x axis, in degrees. A map that fixes have tied to site tells its own; --datum goes before it.
"""

CUT = """\
Writes the part of a map that all of the given options name. The poses stay as they are. Ground
along which no pose is known is found by --runs and --distance alone.
"""

MERGE = """\
Writes one map of two: how the tracks of SECOND lie in the maps of FIRST is found by ground that
both drove over, and a pose graph over both places them. A join must be proven by revisits over
several metres that agree. Without such ground a map joins one that fixes have tied to the same
site, where both lie there surely enough; else it is left out, and where none is left nothing is
written (exit code 1). Ground of SECOND that FIRST has is not stored again. The frame is that of
FIRST, its poses move by what the revisits say. Both files are kept as parents. Files of version 1
cannot be merged.
"""

INSTALL = """\
Copies map files into the folder of the service, as its user and readable by its group, each
entirely or not at all. Afterwards the command load_map NAME takes it up. A file of that name is
kept as NAME.kept-N.map, unless the new ground comes from it. The service itself writes ground.map
and ground-*.map: while it runs they are not replaced. Needs root.
"""

FETCH = """\
Copies maps out of the folder of the service. Needs root.
"""

EXAMPLES = """
examples:
  gprodom map info ground.map
  gprodom map plot ground.map -o map.png
  gprodom map export ground.map --datum 52.3906,13.0645,40 --geojson paths.geojson
  gprodom map cut ground.map --area 0,-5,40,25 -o yard.map
  gprodom map merge monday.map tuesday.map -o site.map
  sudo gprodom map fetch ground -o .
  sudo gprodom map install yard.map
"""


def add_parser(subparsers: Subparsers) -> None:
    """Adds ``map`` and what can be done with one."""
    parser = add_command(subparsers, "map", "look into map files", DESCRIPTION + EXAMPLES)
    works = parser.add_subparsers(metavar="WHAT", required=True)
    _add_info(works)
    _add_plot(works)
    _add_export(works)
    _add_cut(works)
    _add_merge(works)
    add_survey(works)
    _add_install(works)
    _add_fetch(works)


def _add_file(parser: Parser) -> None:
    parser.operand("file", "FILE", "map file")


def _add_number(parser: Parser) -> None:
    parser.option("--map N", int, "number of the map, where the file holds several")


def _add_folder(parser: Parser, kind: type[Path]) -> None:
    parser.option(
        "--folder DIR",
        kind,
        "state.directory of the service (default %(default)s)",
        default=kind(service.FOLDER),
    )


def _add_info(works: Subparsers) -> None:
    parser = add_command(works, "info", "what is in map files", INFO + EXAMPLES, run_info)
    parser.operand("files", "FILE", "map file", nargs="+")
    parser.flag("--runs", "list the runs, too (for cut --runs)")
    add_json_flag(parser)


def _add_plot(works: Subparsers) -> None:
    parser = add_command(works, "plot", "a map from above", PLOT + EXAMPLES, run_plot)
    _add_file(parser)
    parser.picture_output()


def _add_export(works: Subparsers) -> None:
    parser = add_command(works, "export", "paths for other programs", EXPORT + EXAMPLES, run_export)
    _add_file(parser)
    for name in ("geojson", "csv"):
        parser.option(f"--{name} OUT", OutputFile, "see above")
    parser.option("--datum LAT,LON[,HEIGHT[,YAW]]", parse_datum, "see above")
    _add_number(parser)


def _add_cut(works: Subparsers) -> None:
    parser = add_command(works, "cut", "keep a part of a map", CUT + EXAMPLES, run_cut)
    _add_file(parser)
    parser.option("--runs LIST", cut.parse_runs, "runs by number: 0,2-4 (map info)")
    parser.option(
        "--distance FROM:TO", cut.parse_distance, "m of stored ground from the file's beginning"
    )
    parser.option("--area XMIN,YMIN,XMAX,YMAX", cut.parse_area, "rectangle in the map's frame, m")
    _add_number(parser)
    parser.output("OUT", "map file")
    add_json_flag(parser)


def _add_merge(works: Subparsers) -> None:
    parser = add_command(works, "merge", "two sessions become one map", MERGE + EXAMPLES, run_merge)
    parser.operand("first", "FIRST", "map file, whose frame stays")
    parser.operand("second", "SECOND", "map file that joins it")
    parser.output("OUT", "map file")
    add_json_flag(parser)


def _add_install(works: Subparsers) -> None:
    parser = add_command(works, "install", "a map for the service", INSTALL + EXAMPLES, run_install)
    parser.operand("files", "FILE", "map file", nargs="+")
    parser.option("--as NAME", str, "its name there (default FILE's)", dest="name")
    _add_folder(parser, OutputFolder)


def _add_fetch(works: Subparsers) -> None:
    parser = add_command(works, "fetch", "a map of the service", FETCH + EXAMPLES, run_fetch)
    parser.operand("names", "NAME", "map, such as ground", nargs="+", type=str)
    parser.add_argument(
        "-o",
        "--output",
        type=Output,
        default=Output(),
        metavar="OUT",
        help="file or folder (default .)",
    )
    _add_folder(parser, Path)


def run_info(args: argparse.Namespace) -> int:
    """Prints what is in the files."""
    found = [facts(read_map(path)) for path in args.files]
    tell(args.json, found, "\n".join(_as_text(one, args.runs) for one in found))
    return 0


def _as_text(found: dict[str, Any], with_runs: bool) -> str:
    metres = found["kb_per_m"]
    interval_ns = 1e9 * found["sample_interval_s"]
    centre = found["centre_frequency_hz"]
    none = "not in this version"
    parents = none if found["parents"] is None else ", ".join(found["parents"]) or "none"
    rows = {
        "file": found["file"],
        "version": found["version"],
        "identity": found["identity"] or none,
        "parents": parents,
        "sha256": found["sha256"],
        "antenna": f"{found['samples']} samples, {interval_ns:.4g} ns apart"
        + (f", {centre / 1e6:.0f} MHz received" if centre else ""),
        "ground": f"{found['length_m']:.1f} m in {len(found['runs'])} runs, a column every "
        f"{1000 * found['spacing_m']:.0f} mm of {found['features']} features",
        "size": f"{found['bytes']} bytes" + (f", {metres:.2f} kB/m" if metres else ""),
    }
    width = max(map(len, rows))
    text = "\n".join(f"{name.ljust(width)}  {value}" for name, value in rows.items()) + "\n"
    if found["sessions"]:
        header = ["session", "from", "to", "antenna", "at (m)", "program", "robot"]
        sessions = enumerate(found["sessions"])
        text += "\n" + format_table(header, [_session_row(i, one) for i, one in sessions]) + "\n"
    if found["maps"]:
        header = ["map", "from", "to", "paths", "metres", "x (m)", "y (m)", "its frame in site"]
        text += "\n" + format_table(header, [_map_row(one) for one in found["maps"]]) + "\n"
    if with_runs and found["runs"]:
        header = list(found["runs"][0])
        text += "\n" + format_table(header, [list(one.values()) for one in found["runs"]]) + "\n"
    return text


def _session_row(number: int, one: dict[str, Any]) -> list[object]:
    times = [(one[name] or "-")[:19] for name in ("from", "to")]
    place = ", ".join(f"{x:.3g}" for x in one["antenna_m"])
    return [number, *times, one["antenna_id"], place, one["program"], one["robot"] or "-"]


def _map_row(one: dict[str, Any]) -> list[object]:
    spans = ["{:.1f} to {:.1f}".format(*one[name]) for name in ("x_m", "y_m")]
    times = [one[name][:19] for name in ("from", "to")]
    site = site_as_text(one["site"])
    return [one["map"], *times, one["paths"], f"{one['length_m']:.1f}", *spans, site]


def run_plot(args: argparse.Namespace) -> int:
    """Draws a map."""
    file = read_map(args.file)
    file.one_map(file.maps[0] if file.maps else None)
    canvas.save(map_figure(file), args.output)
    return 0


def run_export(args: argparse.Namespace) -> int:
    """Writes the paths of a map."""
    if not (args.geojson or args.csv):
        raise UsageError("nothing to do: give --geojson or --csv")
    file = read_map(args.file)
    number = file.one_map(args.map)
    datum: Datum | None = args.datum or datum_of(file.ground, number)
    if args.geojson and datum is None:
        raise UsageError(
            "--geojson wants --datum LAT,LON, where the map's origin lies: the file does not tell"
        )
    paths = file.paths(number)
    if args.geojson and datum is not None:
        named = {f"{args.file.stem} {i}": path for i, path in enumerate(paths)}
        write_geojson(args.geojson, named, datum)
    if args.csv:
        piece = np.repeat(np.arange(len(paths)), [len(path) for path in paths])
        write_csv(args.csv, joined(paths), datum, piece)
    print(f"{len(paths)} paths, {sum(map(len, paths))} poses of map {number}")
    return 0


def run_cut(args: argparse.Namespace) -> int:
    """Writes a part of a map."""
    if all(each is None for each in (args.runs, args.distance, args.area, args.map)):
        raise UsageError("nothing to cut: give some of --runs, --distance, --area and --map")
    file = read_map(args.file)
    chosen = np.ones(len(file.columns["x"]), dtype=bool)
    if args.runs is not None:
        chosen &= cut.of_runs(file, args.runs)
    if args.distance is not None:
        chosen &= cut.of_distance(file, args.distance)
    if args.area is not None:
        chosen &= cut.of_area(file, file.one_map(args.map), args.area)
    elif args.map is not None:
        chosen &= np.asarray(file.columns["map"] == file.one_map(args.map))
    write_bytes(args.output, cut.cut(file, chosen))
    kept = read_map(args.output).length_m
    figures = {"length_m": file.length_m, "kept_m": kept}
    tell(args.json, figures, f"{kept:.1f} of {file.length_m:.1f} m kept")
    return 0


def run_merge(args: argparse.Namespace) -> int:
    """Writes one map of two."""
    files = read_map(args.first), read_map(args.second)
    merged = merging.merge(*files)
    write_bytes(args.output, merged.data)
    lengths = [file.length_m for file in (*files, read_map(args.output))]
    figures: dict[str, Any] = dict(zip(("first_m", "second_m", "length_m"), lengths, strict=True))
    figures |= {"known_m": merged.known_m, "joins": merged.joins}
    lines = [merging.as_text(join) for join in merged.joins]
    lines.append("{:.1f} m and {:.1f} m: {:.1f} m".format(*lengths))
    tell(args.json, figures, "\n".join(lines))
    return 0


def run_install(args: argparse.Namespace) -> int:
    """Copies maps into the folder of the service."""
    if args.name and len(args.files) > 1:
        raise UsageError("--as: gives a name to one file only")
    files: list[tuple[MapFile, Path]] = [
        (read_map(path), service.path_in(args.folder, args.name or path.name))
        for path in args.files
    ]
    for file, path in files:
        for said in service.install(file.data, path):
            print(said)
        print(f"{path}: {file.length_m:.1f} m of ground")
    return 0


def run_fetch(args: argparse.Namespace) -> int:
    """Copies maps out of the folder of the service."""
    into_folder = args.output.is_dir()
    if len(args.names) > 1 and not into_folder:
        raise UsageError(f"-o: {args.output} is not a folder, as several maps want")
    for name in args.names:
        path = service.path_in(args.folder, name)
        try:
            file = service.fetch(path)
        except FileNotFoundError:
            raise Error(f"{path}: no such file") from None
        output = args.output / path.name if into_folder else args.output
        write_bytes(output, file.data)
        print(f"{output}: {file.length_m:.1f} m of ground")
    return 0
