"""``gprodom score``."""

import argparse
from pathlib import Path

import numpy as np

from gprodom.config import read_channels
from gprodom.console import tell
from gprodom.errors import UsageError
from gprodom.files import OutputFolder
from gprodom.options import Parser, Subparsers, add_command, numbers
from gprodom.score.align import add_align_option, add_first_m_option
from gprodom.score.associate import MAX_GAP_S, UNCOVERED_M, associate, warn_of_uncovered
from gprodom.score.consistency import TruthError
from gprodom.score.figures import Comparison, compare
from gprodom.score.frames import in_last_frame, warn_of_frames
from gprodom.score.record import Record, describe, make_record, sequence_name
from gprodom.score.sources import FRAMES, Source, read_estimate, read_truth
from gprodom.trajectory import Trajectory

DESCRIPTION = f"""\
Scores a trajectory against truth. EST and TRUTH are each an LCM log, a TUM file, a total station's
ts_meas.csv, or a sequence (directory or zip). Of a log, EST is ODOMETRY_MAP (or ODOMETRY, see
--frame) as it was published, TRUTH is TOTAL_STATION, or where there is none the same as EST.

The estimate is interpolated to the truth's stamps. Truth outside the estimate's span, or in a gap
of the estimate of more than {MAX_GAP_S:g} s, is left out and counted as `excluded`; where the truth
travels {UNCOVERED_M:g} m or more meanwhile, that is warned of.

figures:
  ate_rmse_m    RMS distance to the truth after alignment; in the horizontal plane for first and
                se2, in space for none and se3
  rpe_1m_m      RMS relative error over consecutive stretches of 1 m of the truth's path: of point
                distances, or of the full relative translation where the truth has attitude
  end_m         distance to the truth at the last point, after alignment
  distance_pct  end_m in percent of the distance that the truth travels
  nees_xy/_yaw  mean normalised squared error by the estimate's own covariance (2 and 1 where it
                is right), the truth's noise and clock counted (--truth-sigma,
                --truth-delay-sigma); truth placed by its first pose, or where it has no attitude
                by all its points, each weighed with what the estimate claims to know there, and
                the covariance of that placing counted; null without covariance, yaw also null
                without attitude
  n             points compared
  before_m      of a drive that was located in the map of an earlier one, or was reset: metres
                driven before, which are left out because they are in another frame
  excluded      truth points left out; excluded_s, excluded_m: for how long, and how far the truth
                travels meanwhile

examples:
  gprodom score out.lcmlog 1700001000-0-gates_g-cmu-gpr.zip --plot report
  gprodom score estimate.tum truth.tum --align se3 --json
  gprodom score live.lcmlog replay.lcmlog --align none --frame odom
"""


def add_parser(subparsers: Subparsers) -> None:
    """Adds the subcommand."""
    parser = add_command(subparsers, "score", "compare a trajectory with truth", DESCRIPTION, run)
    parser.operand("estimate", "EST", "trajectory to score")
    parser.operand("truth", "TRUTH", "the true trajectory")
    add_align_option(
        parser,
        "how EST is placed in the truth's frame (default se2): not at all; turned about z and "
        "moved by its first metres, or by all points; turned in space and moved by all points",
    )
    add_first_m_option(parser)
    parser.option(
        "--prism X,Y,Z",
        numbers("three numbers X,Y,Z", lambda values: len(values) == 3),
        "point whose position the truth measured (m, body frame; default 0,0,0)",
    )
    parser.choice("--frame", FRAMES, "map", "frame of the poses of a log (default map)")
    add_truth_error(parser)
    parser.common_options()
    parser.option(
        "--plot DIR", OutputFolder, "folder for trajectory.png, error.png and report.html"
    )


def add_truth_error(parser: Parser) -> None:
    """``--truth-sigma`` and ``--truth-delay-sigma``."""
    exact = TruthError()
    parser.option(
        "--truth-sigma M",
        exact.sigma_m,
        "noise of the truth, of each coordinate (m, one standard deviation; default "
        f"{exact.sigma_m:g}, a total station's); counts in the NEES",
    )
    parser.option(
        "--truth-delay-sigma S",
        exact.delay_sigma_s,
        "offset of the truth's clock (s, one standard deviation; default 0)",
    )


def truth_error_of(args: argparse.Namespace) -> TruthError:
    """The values of these options."""
    if args.truth_sigma < 0 or args.truth_delay_sigma < 0:
        raise UsageError("--truth-sigma, --truth-delay-sigma: expected 0 or more")
    return TruthError(args.truth_sigma, args.truth_delay_sigma)


def at_prism(estimate: Trajectory, truth: Trajectory, prism: tuple[float, ...]) -> Trajectory:
    """The estimate's path of the point whose truth was measured."""
    if truth.orientation is not None:
        raise UsageError("--prism is for a truth of points; this one has attitude")
    return estimate.moved(np.array(prism))


def run(args: argparse.Namespace) -> int:
    """Runs the subcommand."""
    if not args.first_m > 0:
        raise UsageError(f"--first-m {args.first_m:g}: expected a distance above 0")
    truth_error = truth_error_of(args)
    channels = read_channels(args.configs, args.overrides)
    estimate = read_estimate(args.estimate, args.frame, channels)
    truth = read_truth(args.truth, args.frame, channels)
    warn_of_frames(estimate.trajectory, estimate.frame)
    path = in_last_frame(estimate.trajectory, estimate.frame)
    if args.prism is not None:
        path = at_prism(path, truth.trajectory, args.prism)
    pairs = associate(path, truth.trajectory)
    warn_of_uncovered(pairs)
    comparison = compare(pairs, args.align, args.first_m, truth_error)
    record = _record(estimate, args.truth, comparison)
    text = describe(record)
    if args.plot is not None:
        from gprodom.score.page import write_report

        text += "\nwritten: " + ", ".join(map(str, write_report(comparison, record, args.plot)))
    tell(args.json, record.as_dict(), text)
    return 0


def _record(estimate: Source, truth: Path, comparison: Comparison) -> Record:
    """Method and mode are read off the name that a benchmark gives: METHOD[.smoothed].tum."""
    method = estimate.path.name.split(".")[0]
    mode = "smoothed" if estimate.path.name.endswith(".smoothed.tum") else "causal"
    return make_record(
        sequence_name(truth),
        method,
        mode,
        comparison.alignment,
        comparison.figures,
        estimate.jumps,
        frame=estimate.frame,
    )
