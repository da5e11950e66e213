# Written by scripts/stubs from src/python/: not to be edited.
"""
Compiled parts of gprodom.
"""

from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing

__all__: list[str] = [
    "Alignment",
    "Apex",
    "CommandName",
    "ConfigError",
    "DetailsRetention",
    "FileError",
    "FilterConfig",
    "GlobalMatch",
    "GlobalSearch",
    "GlobalSearchOptions",
    "GprTrace",
    "GroundMap",
    "Odometry",
    "Outputs",
    "PatchFilter",
    "PatchFilterOptions",
    "PatchMatcher",
    "PathLength",
    "Peak",
    "PeakCounts",
    "PeakExtractor",
    "PeakOptions",
    "RESET_ALL",
    "RevisitMatch",
    "RevisitOptions",
    "RevisitSearch",
    "RevisitSearchOptions",
    "Sight",
    "Standstill",
    "TrackDisplacement",
    "accel_scale_at_rest",
    "align_bscan",
    "align_curves",
    "align_sfm",
    "band_pass",
    "build_sfm",
    "check_traces",
    "coherence",
    "depth_of",
    "depth_row",
    "describe_config",
    "design_band_pass",
    "dewow",
    "dominant_energy_curve",
    "envelope",
    "find_apexes",
    "find_patch",
    "gain_curve",
    "install_map",
    "iswt",
    "keep_details",
    "match_patch",
    "remove_background",
    "standstills",
    "swt",
    "track_time_zero",
    "travel_time",
]

class FilterConfig:
    """
    Options of DetailsRetention: the keys gpr.filter.* of the configuration and what is fixed there.
    """

    background: str
    wavelet: str
    def __init__(self) -> None: ...
    @property
    def background_memory(self) -> int: ...
    @background_memory.setter
    def background_memory(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def band_high(self) -> float: ...
    @band_high.setter
    def band_high(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def band_length(self) -> float: ...
    @band_length.setter
    def band_length(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def band_low(self) -> float: ...
    @band_low.setter
    def band_low(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def dewow_window(self) -> float: ...
    @dewow_window.setter
    def dewow_window(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def gain_flat_after(self) -> int: ...
    @gain_flat_after.setter
    def gain_flat_after(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def gain_power(self) -> float: ...
    @gain_power.setter
    def gain_power(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def gain_rate(self) -> float: ...
    @gain_rate.setter
    def gain_rate(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def time_zero_max(self) -> float: ...
    @time_zero_max.setter
    def time_zero_max(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def wavelet_levels(self) -> int: ...
    @wavelet_levels.setter
    def wavelet_levels(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def wavelet_threshold(self) -> float: ...
    @wavelet_threshold.setter
    def wavelet_threshold(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class DetailsRetention:
    """
    Details retention on a stream of traces, as the radar front ends run it.
    """
    def __init__(self, config: FilterConfig = ...) -> None: ...
    def filter(
        self,
        traces: typing.Annotated[numpy.typing.ArrayLike, numpy.float32],
        sample_interval: typing.SupportsFloat | typing.SupportsIndex,
        standing: bool = False,
    ) -> tuple[
        numpy.typing.NDArray[numpy.float32],
        numpy.typing.NDArray[numpy.int8],
        numpy.typing.NDArray[numpy.float64],
        numpy.typing.NDArray[numpy.float64],
    ]:
        """
        Takes in (traces, samples), oldest first; returns the filtered traces (float32, NaN where bad), and for each its quality (0 good, 1 dead, 2 spiked), the removed delay (samples) and the measured noise (counts).
        """
    def reset(self) -> None:
        """
        Forgets all traces.
        """

class PeakOptions:
    """
    How peaks are found and fitted; see gpr/peaks.h.
    """

    fit: bool
    def __init__(
        self,
        *,
        fit: bool = True,
        noise_sigma: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        min_snr: typing.SupportsFloat | typing.SupportsIndex = 3.5,
        min_relative: typing.SupportsFloat | typing.SupportsIndex = 0.05,
        gate_periods: typing.SupportsFloat | typing.SupportsIndex = 1.5,
        max_joint: typing.SupportsInt | typing.SupportsIndex = 3,
        significance: typing.SupportsFloat | typing.SupportsIndex = 0.01,
        max_residual: typing.SupportsFloat | typing.SupportsIndex = 0.3,
        max_iterations: typing.SupportsInt | typing.SupportsIndex = 15,
    ) -> None: ...
    @property
    def gate_periods(self) -> float: ...
    @gate_periods.setter
    def gate_periods(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def max_iterations(self) -> int: ...
    @max_iterations.setter
    def max_iterations(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def max_joint(self) -> int: ...
    @max_joint.setter
    def max_joint(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def max_residual(self) -> float: ...
    @max_residual.setter
    def max_residual(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def min_relative(self) -> float: ...
    @min_relative.setter
    def min_relative(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def min_snr(self) -> float: ...
    @min_snr.setter
    def min_snr(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def noise_sigma(self) -> float: ...
    @noise_sigma.setter
    def noise_sigma(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def significance(self) -> float: ...
    @significance.setter
    def significance(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class Peak:
    """
    A reflection; times in samples, see gpr/peaks.h.
    """
    @property
    def alpha(self) -> float: ...
    @property
    def amplitude(self) -> float: ...
    @property
    def beta(self) -> float: ...
    @property
    def covariance(self) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[7, 7]"]:
        """
        7x7: sample, amplitude, alpha, beta, gamma, omega, phi
        """
    @property
    def gamma(self) -> float: ...
    @property
    def gate_begin(self) -> int: ...
    @property
    def gate_end(self) -> int: ...
    @property
    def joint(self) -> int: ...
    @property
    def omega(self) -> float: ...
    @property
    def phi(self) -> float: ...
    @property
    def residual(self) -> float: ...
    @property
    def sample(self) -> float: ...

class PeakCounts:
    """
    Counts of all pulses so far, by result.
    """
    @property
    def accepted(self) -> int: ...
    @property
    def insignificant(self) -> int: ...
    @property
    def misfit(self) -> int: ...
    @property
    def not_converged(self) -> int: ...
    @property
    def out_of_bounds(self) -> int: ...
    @property
    def pulses(self) -> int: ...
    @property
    def traces(self) -> int: ...

class PeakExtractor:
    """
    Peaks of filtered traces.
    """
    def __init__(self, options: PeakOptions = ...) -> None: ...
    def extract(self, trace: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]) -> list[Peak]:
        """
        Peaks of one trace (samples,), in order of time.
        """
    def extract_all(
        self, traces: typing.Annotated[numpy.typing.ArrayLike, numpy.float32]
    ) -> list[list[Peak]]:
        """
        Peaks of each row of (traces, samples): a list per trace.
        """
    @property
    def counts(self) -> PeakCounts: ...

class Alignment:
    """
    Result of aligning one window with another; shifts in columns.
    """
    @property
    def distance(self) -> float:
        """
        at the minimum
        """
    @property
    def overlap(self) -> int:
        """
        common columns at the minimum
        """
    @property
    def shift(self) -> int:
        """
        of the minimum, negative as traces enter
        """
    @property
    def subcolumn(self) -> float:
        """
        shift with its fraction
        """
    @property
    def valid(self) -> bool:
        """
        a minimum inside the limits, with energy
        """
    @property
    def variance(self) -> float:
        """
        of subcolumn, columns^2
        """

class Apex:
    """
    Apex of a hyperbola in a B-scan.
    """
    @property
    def amplitude(self) -> float:
        """
        of the mean echo along the hyperbola
        """
    @property
    def column(self) -> float:
        """
        with its fraction
        """
    @property
    def semblance(self) -> float:
        """
        stacked energy over energy, 0 to 1
        """
    @property
    def time(self) -> float:
        """
        s, two-way, from time zero
        """
    @property
    def widening(self) -> float:
        """
        s per column: 2 spacing / wave speed
        """

class RevisitMatch:
    """
    Place of a patch in the memory.
    """
    @property
    def accepted(self) -> bool:
        """
        the evidence suffices
        """
    @property
    def correlation(self) -> float:
        """
        at the place
        """
    @property
    def half_sigmas(self) -> float:
        """
        correlation of the weaker half, in standard deviations of a random match
        """
    @property
    def mirrored(self) -> bool:
        """
        driven the other way
        """
    @property
    def offset_m(self) -> float:
        """
        query centre minus memory centre, along the memory's direction
        """
    @property
    def scale(self) -> float:
        """
        metres of memory per metre of query
        """
    @property
    def score(self) -> float:
        """
        evidence over the second best place
        """
    @property
    def sigma_m(self) -> float:
        """
        standard deviation of offset_m
        """
    @property
    def valid(self) -> bool:
        """
        the memory covers the query near the prior
        """

class RevisitOptions:
    """
    See gpr/revisit.h.
    """
    def __init__(self) -> None: ...
    @property
    def depth_blocks(self) -> int: ...
    @depth_blocks.setter
    def depth_blocks(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def lobe_m(self) -> float: ...
    @lobe_m.setter
    def lobe_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def min_half(self) -> float: ...
    @min_half.setter
    def min_half(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def min_score(self) -> float: ...
    @min_score.setter
    def min_score(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def scales(self) -> list[float]: ...
    @scales.setter
    def scales(
        self, arg0: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex]
    ) -> None: ...
    @property
    def surround_m(self) -> float: ...
    @surround_m.setter
    def surround_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def time_shift(self) -> float: ...
    @time_shift.setter
    def time_shift(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class PatchFilterOptions:
    """
    See gpr/patch_filter.h.
    """
    def __init__(self) -> None: ...
    @property
    def high_cut(self) -> float: ...
    @high_cut.setter
    def high_cut(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def long_cut(self) -> float: ...
    @long_cut.setter
    def long_cut(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def low_cut(self) -> float: ...
    @low_cut.setter
    def low_cut(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def max_long_cut(self) -> float: ...
    @max_long_cut.setter
    def max_long_cut(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def max_rows(self) -> int: ...
    @max_rows.setter
    def max_rows(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def short_cut(self) -> float: ...
    @short_cut.setter
    def short_cut(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def spectrum_floor(self) -> float: ...
    @spectrum_floor.setter
    def spectrum_floor(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def wave_speed(self) -> float: ...
    @wave_speed.setter
    def wave_speed(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class PatchFilter:
    """
    Traces -> features; see gpr/patch_filter.h.
    """
    def __init__(
        self,
        traces: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[m, n]"],
        spacing: typing.SupportsFloat | typing.SupportsIndex,
        sample_interval: typing.SupportsFloat | typing.SupportsIndex,
        options: PatchFilterOptions = ...,
    ) -> None: ...
    def apply(
        self, traces: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[m, n]"]
    ) -> typing.Annotated[numpy.typing.NDArray[numpy.float32], "[m, n]"]:
        """
        Features (columns, rows) of traces (columns, samples).
        """
    @property
    def centre_frequency(self) -> float:
        """
        Hz
        """
    @property
    def row_interval(self) -> float:
        """
        s
        """
    @property
    def rows(self) -> int: ...

class PatchMatcher:
    """
    See gpr/revisit.h.
    """
    def __init__(
        self,
        filter: PatchFilter,
        spacing: typing.SupportsFloat | typing.SupportsIndex,
        options: RevisitOptions = ...,
    ) -> None: ...
    def match(
        self,
        memory: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[m, n]"],
        query: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[m, n]"],
        expected: typing.SupportsFloat | typing.SupportsIndex,
        bound: typing.SupportsFloat | typing.SupportsIndex,
    ) -> RevisitMatch:
        """
        The RevisitMatch of two sets of features (columns, rows). The query's centre is
        expected within `bound` m of the place `expected` m from the memory's centre.
        """

class RevisitSearchOptions:
    """
    See gpr/revisit_search.h.
    """

    clear_once: bool
    matcher: RevisitOptions
    def __init__(self) -> None: ...
    @property
    def agree_m(self) -> float: ...
    @agree_m.setter
    def agree_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def certainty(self) -> float: ...
    @certainty.setter
    def certainty(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def drift(self) -> float: ...
    @drift.setter
    def drift(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def lost(self) -> float: ...
    @lost.setter
    def lost(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def max_stretch(self) -> float: ...
    @max_stretch.setter
    def max_stretch(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def min_half(self) -> float: ...
    @min_half.setter
    def min_half(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def min_patches(self) -> int: ...
    @min_patches.setter
    def min_patches(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def nowhere(self) -> float: ...
    @nowhere.setter
    def nowhere(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def patch_m(self) -> float: ...
    @patch_m.setter
    def patch_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class RevisitSearch:
    """
    Bayes filter for revisits along the track; see gpr/revisit_search.h.
    """
    def __init__(
        self,
        filter: PatchFilter,
        spacing: typing.SupportsFloat | typing.SupportsIndex,
        options: RevisitSearchOptions = ...,
    ) -> None: ...
    def forget(self) -> None: ...
    def look(
        self,
        newest: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[m, n]"],
        moved: typing.SupportsFloat | typing.SupportsIndex,
        memory: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[m, n]"],
        expected: typing.SupportsFloat | typing.SupportsIndex,
        bound: typing.SupportsFloat | typing.SupportsIndex,
        stretch_sigma: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        stretch_change: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> tuple[float, float, RevisitMatch] | None:
        """
        newest: features (columns, rows) in the order driven, `moved` m after those of the
        last call. The centre of their last patch is expected within `bound` m of the column
        `expected` of `memory`. stretch_sigma, stretch_change: standard deviations of the
        logarithm of the length ratio of memory and query, and of its change since the last
        call. Returns (column, certainty, RevisitMatch), or None if no place is certain.
        """
    @property
    def patch_columns(self) -> int: ...

class GlobalMatch:
    """
    A place found in the whole memory.
    """
    @property
    def accepted(self) -> bool:
        """
        the margin suffices
        """
    @property
    def column(self) -> float:
        """
        of the memory, at the query's centre
        """
    @property
    def margin(self) -> float:
        """
        over the second best place
        """
    @property
    def mirrored(self) -> bool:
        """
        driven the other way
        """
    @property
    def score(self) -> float:
        """
        in standard deviations of a random match
        """
    @property
    def valid(self) -> bool:
        """
        at least one place was compared
        """

class GlobalSearchOptions:
    """
    See gpr/global_search.h.
    """
    def __init__(self) -> None: ...
    @property
    def distinct_m(self) -> float: ...
    @distinct_m.setter
    def distinct_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def min_margin(self) -> float: ...
    @min_margin.setter
    def min_margin(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def piece_m(self) -> float: ...
    @piece_m.setter
    def piece_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def rows(self) -> int: ...
    @rows.setter
    def rows(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def slack(self) -> float: ...
    @slack.setter
    def slack(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def thinning(self) -> int: ...
    @thinning.setter
    def thinning(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...

class GlobalSearch:
    """
    See gpr/global_search.h.
    """
    def __init__(
        self,
        filter: PatchFilter,
        spacing: typing.SupportsFloat | typing.SupportsIndex,
        options: GlobalSearchOptions = ...,
    ) -> None: ...
    def add_run(
        self,
        first: typing.SupportsInt | typing.SupportsIndex,
        features: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[m, n]"],
    ) -> None: ...
    def find(
        self, query: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[m, n]"]
    ) -> GlobalMatch: ...
    @property
    def bytes(self) -> int: ...

class GprTrace:
    """
    One radar trace, in counts.
    """
    @property
    def sample_interval(self) -> float:
        """
        s
        """
    @property
    def samples(self) -> numpy.typing.NDArray[numpy.float32]:
        """
        (samples,) float32, a copy
        """
    @property
    def seq(self) -> int: ...
    @property
    def time(self) -> int:
        """
        ns
        """
    @property
    def time_zero(self) -> float:
        """
        s; sample i was taken i sample_interval - time_zero after the pulse left
        """

class Standstill:
    """
    The antenna stood between two times (ns). sigma: motion that the test may have missed, m.
    since: the antenna has not moved since this time, because the traces then and now are
    equal; 0: not compared.
    """
    def __init__(
        self,
        time_from: typing.SupportsInt | typing.SupportsIndex,
        time_to: typing.SupportsInt | typing.SupportsIndex,
        sigma: typing.SupportsFloat | typing.SupportsIndex,
        source: str = "python",
        score: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        since: typing.SupportsInt | typing.SupportsIndex = 0,
    ) -> None: ...

class PathLength:
    """
    Unsigned distance that the antenna moved, in a unit of the ground that the estimator converts to metres. valid: False if the distance is not known. unit: lengths of another number cannot be compared.
    """
    def __init__(
        self,
        time_from: typing.SupportsInt | typing.SupportsIndex,
        time_to: typing.SupportsInt | typing.SupportsIndex,
        lengths: typing.SupportsFloat | typing.SupportsIndex,
        valid: bool = True,
        source: str = "python",
        score: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        unit: typing.SupportsInt | typing.SupportsIndex = 0,
    ) -> None: ...

class TrackDisplacement:
    """
    Signed distance that the antenna moved along its track, m, forwards positive; sigma: its standard deviation, m. valid: False if the distance is not known.
    """
    def __init__(
        self,
        time_from: typing.SupportsInt | typing.SupportsIndex,
        time_to: typing.SupportsInt | typing.SupportsIndex,
        distance: typing.SupportsFloat | typing.SupportsIndex,
        sigma: typing.SupportsFloat | typing.SupportsIndex,
        valid: bool = True,
        source: str = "python",
        score: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> None: ...

class Sight:
    """
    The antenna moved at times_least times the slowest speed that the Standstill test detects.
    """
    def __init__(
        self,
        time_from: typing.SupportsInt | typing.SupportsIndex,
        time_to: typing.SupportsInt | typing.SupportsIndex,
        times_least: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None: ...

class Outputs:
    """
    Results of one step or of a whole run, each list in time order. A path to
    plot is odometry_map's: odometry is without the corrections of loop closures.
    """
    def __repr__(self) -> str: ...
    @property
    def corrections(self) -> list[dict]:
        """
        One dict per correction (map to odom), twice a second from the first loop closure on:
        time (ns), position (3,) m and orientation (w x y z) of odom in map, covariance (6, 6)
        of the robot's pose in map, revisits.
        """
    @property
    def displacements(self) -> list[dict]:
        """
        One dict per displacement measurement that took effect.
        """
    @property
    def odometry(self) -> dict[str, numpy.ndarray]:
        """
        Arrays of one row per estimate, in odom: continuous, and without the corrections of
        loop closures. time (ns), position (m), orientation (w x y z), velocity (m/s) and
        angular_velocity (rad/s) in body, pose_covariance (n, 36), gyro_bias (rad/s),
        accel_bias (m/s^2), wheel_scale (value, sigma), flags.
        """
    @property
    def odometry_map(self) -> dict[str, numpy.ndarray]:
        """
        The same poses in map: with the correction of loop closures in effect at that time, so
        it may jump where one comes into effect. The best path as published.
        """
    @property
    def status(self) -> list[dict]:
        """
        One dict per second of data: time, health, reasons, values.
        """
    @property
    def warnings(self) -> list[str]: ...

class CommandName:
    """
    Names of the commands in command_t.

    Members:

      reset

      save_map

      load_map

      locate_at
    """

    __members__: typing.ClassVar[dict[str, CommandName]]
    load_map: typing.ClassVar[CommandName]
    locate_at: typing.ClassVar[CommandName]
    reset: typing.ClassVar[CommandName]
    save_map: typing.ClassVar[CommandName]
    @typing.overload
    def __eq__(self, other: CommandName) -> bool: ...
    @typing.overload
    def __eq__(self, other: typing.Any) -> bool: ...
    def __getstate__(self) -> int: ...
    def __hash__(self) -> int: ...
    def __index__(self) -> int: ...
    def __init__(self, value: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __int__(self) -> int: ...
    @typing.overload
    def __ne__(self, other: CommandName) -> bool: ...
    @typing.overload
    def __ne__(self, other: typing.Any) -> bool: ...
    def __repr__(self) -> str: ...
    def __setstate__(self, state: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    def __str__(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def value(self) -> int: ...

class ConfigError(ValueError):
    pass

class FileError(OSError):
    pass

class Odometry:
    """
    The estimator. Times in ns, SI units; IMU in its own axes, see config imu.rpy_body_imu.
    """
    def __init__(
        self,
        config: str | collections.abc.Sequence[str] = "",
        set: str | collections.abc.Sequence[str] = [],
        front_end: typing.Any = None,
    ) -> None:
        """
        config: path of a YAML file, or several, of which later ones override earlier ones;
        empty for the defaults. set: an override 'key=value', or several. Raises ConfigError
        with file, line and key. front_end: a radar front end of your own instead of
        gpr.front_end: a class, or another callable without arguments, whose objects have
        add_trace(trace: GprTrace), tick(time: int) -> list of findings and reset().
        """
    def add_displacement(
        self,
        time: typing.SupportsInt | typing.SupportsIndex,
        time_from: typing.SupportsInt | typing.SupportsIndex,
        time_to: typing.SupportsInt | typing.SupportsIndex,
        distance: typing.SupportsFloat | typing.SupportsIndex,
        sigma: typing.SupportsFloat | typing.SupportsIndex,
        revisit: bool = False,
        mirrored: bool = False,
    ) -> None:
        """
        Displacement along the track (m) between two times, from another process. revisit: it
        is relative to a place passed before, at any earlier time.
        """
    def add_fix(
        self,
        time: typing.SupportsInt | typing.SupportsIndex,
        position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        covariance: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 3]"],
        geodetic: bool = False,
        quality: typing.SupportsInt | typing.SupportsIndex = 3,
        antenna_id: typing.SupportsInt | typing.SupportsIndex = 0,
        heading: typing.SupportsFloat | typing.SupportsIndex | None = None,
        heading_sigma: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> None:
        """
        A position from outside, as position_fix_t has it. position: (3,) m in site, or latitude,
        longitude (deg) and height (m); covariance: (3, 3) m^2.
        """
    def add_gpr(
        self,
        time: typing.SupportsInt | typing.SupportsIndex,
        samples: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        sample_interval: typing.SupportsFloat | typing.SupportsIndex,
        time_zero: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        seq: typing.SupportsInt | typing.SupportsIndex = 0,
        antenna_id: typing.SupportsInt | typing.SupportsIndex = 0,
    ) -> None:
        """
        samples: (n,) counts; sample_interval and time_zero: s; antenna_id: of gpr.antennas.
        """
    def add_imu(
        self,
        time: typing.SupportsInt | typing.SupportsIndex,
        acceleration: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
        angular_velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[3, 1]"],
    ) -> None:
        """
        acceleration: (3,) m/s^2, specific force; angular_velocity: (3,) rad/s.
        """
    def add_wheel(
        self,
        time: typing.SupportsInt | typing.SupportsIndex,
        distance: typing.SupportsFloat | typing.SupportsIndex,
        resolution: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> None:
        """
        distance: signed, cumulative, metres; resolution: of one tick of the encoder, metres,
        0 if it is finer than wheel.noise_floor.
        """
    def add_wheels(
        self,
        time: typing.SupportsInt | typing.SupportsIndex,
        left: typing.SupportsFloat | typing.SupportsIndex,
        right: typing.SupportsFloat | typing.SupportsIndex,
        resolution: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    ) -> None:
        """
        left, right: signed, cumulative, metres; resolution: as of add_wheel. Instead of add_wheel.
        """
    def finish(self) -> Outputs:
        """
        The same at the end of the data: nothing more will come.
        """
    def forget(self) -> None:
        """
        Restarts and forgets the ground too.
        """
    def load_map(self, path: str) -> None:
        """
        Loads the ground of a saved map; when it is recognised, map becomes its frame.
        Raises FileError, and then nothing has changed.
        """
    def locate_at(
        self,
        x: typing.SupportsFloat | typing.SupportsIndex,
        y: typing.SupportsFloat | typing.SupportsIndex,
        yaw: typing.SupportsFloat | typing.SupportsIndex,
        sigma: typing.SupportsFloat | typing.SupportsIndex,
        map: typing.SupportsInt | typing.SupportsIndex = -1,
    ) -> None:
        """
        The robot is now about there in the map of earlier ground (m, rad; sigma: of the
        position, m; map: its number, -1: the one with the most ground). That ground is
        searched first; map becomes its frame once a revisit has proved it. Raises FileError
        where there is no map, ValueError on figures that make no sense.
        """
    def record(self) -> None:
        """
        Keep all states for smoothed(); call it before the first measurement.
        """
    def recorded(self) -> dict[str, numpy.ndarray]:
        """
        Time, position and orientation of every state as it left the fixed-lag window.
        """
    def reset(self) -> None:
        """
        Restarts at the initialiser. The ground driven over is kept; when it is recognised, map becomes its frame.
        """
    def run(
        self,
        imu_time: typing.Any,
        acceleration: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
        angular_velocity: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
        wheel_time: typing.Any,
        wheel_distance: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
        gpr_time: typing.Any,
        traces: typing.Annotated[numpy.typing.ArrayLike, numpy.float32],
        sample_interval: typing.SupportsFloat | typing.SupportsIndex = 2e-10,
        progress: collections.abc.Callable[[float], None] | None = None,
        wheel_resolution: typing.SupportsFloat | typing.SupportsIndex = 0.0,
        gpr_antenna: typing.Annotated[numpy.typing.ArrayLike, numpy.int32] | None = None,
    ) -> Outputs:
        """
        Runs a whole sequence, merged by stamp. Give empty arrays for a missing sensor. Times
        are integers, nanoseconds; others raise ValueError.
        wheel_distance: (n,), or (n, 2) of left and right wheels; wheel_resolution: as of
        add_wheel; gpr_antenna: (n,) the antenna_id of each trace, None: 0.
        """
    def save_map(self, path: str) -> None:
        """
        Saves the ground driven over, with its poses, to a file. Raises FileError.
        """
    def smoothed(self) -> dict[str, numpy.ndarray]:
        """
        Time, position and orientation of every state from one solution over all data so far.
        """
    def step(self) -> Outputs:
        """
        What the data since the last step gave.
        """

class GroundMap:
    """
    A map file: docs/map_format.md. Columns are numbered from the first, times in ns.
    """
    @staticmethod
    def read(path: str) -> GroundMap:
        """
        A file with what its estimator has added since in NAME.new beside it. Raises
        FileError.
        """
    def __init__(self, name: str, content: bytes) -> None:
        """
        name: of the file, for errors. Raises FileError where the bytes are not a whole map.
        """
    def columns(self, reach: typing.SupportsFloat | typing.SupportsIndex = 1.0) -> dict:
        """
        x, y (m) of the body and number of the map at each column, from places within `reach`
        m along the track; NaN and -1 where there is none.
        """
    def datum(self, map: typing.SupportsInt | typing.SupportsIndex) -> typing.Any:
        """
        How the frame of a map lies in site: x, y, z (m), yaw (rad), their covariance (4, 4);
        origin of site (latitude, longitude in deg, height in m; None where it is not known),
        and by it the frame's own, with the angle from east to its x axis (deg, to the left).
        None where no fixes have tied it.
        """
    def features_alone(self) -> GroundMap:
        """
        The same ground as version 1 has it: features, which no later filter replaces.
        """
    def merged(self, other: GroundMap) -> dict:
        """
        This map and another file's, its tracks joined where ground that both drove over
        proves how they lie: ground, known_m (m of the other's ground that was left out),
        joins (of each map of the other). Where no ground proves it, maps in one site are
        joined by their datums. Raises ValueError where the files cannot be compared.
        """
    def part(
        self,
        ranges: collections.abc.Sequence[
            tuple[
                typing.SupportsInt | typing.SupportsIndex, typing.SupportsInt | typing.SupportsIndex
            ]
        ],
    ) -> GroundMap:
        """
        The ground of these columns, [first, end), in ascending order; in the same maps.
        """
    def places(self) -> dict:
        """
        Poses known: column, time, distance along the track (m), pose of
        the body (x, y in m, yaw in rad) in the frame of the map `map`.
        """
    def runs(self) -> dict:
        """
        Stretches driven one way without a gap: columns [first, end), direction
        (-1: backwards), distance along the track at the first column, m.
        """
    def sessions(self) -> list:
        """
        The drives and antennas that the ground comes from: times of the first and last column
        stored (ns), position of the antenna in body (m), its id (0 before version 6),
        program, robot (empty where it is not known), and standard deviations of the odometry:
        m and rad after a metre, and ln of the wheel's scale. None in version 1.
        """
    def times(self) -> numpy.typing.NDArray[numpy.int64]:
        """
        Of each column.
        """
    def to_bytes(self) -> bytes: ...
    @property
    def centre_frequency(self) -> float:
        """
        Hz, of the received spectrum
        """
    @property
    def identity(self) -> str:
        """
        of the file
        """
    @property
    def parents(self) -> list[str]:
        """
        identities of the files it was made from
        """
    @property
    def rows(self) -> int:
        """
        features of a column; 0: there is no ground
        """
    @property
    def sample_interval(self) -> float:
        """
        s
        """
    @property
    def samples(self) -> int:
        """
        of a trace; 0: no trace was seen
        """
    @property
    def spacing(self) -> float:
        """
        m
        """
    @property
    def version(self) -> int:
        """
        of the file
        """

def accel_scale_at_rest(force: typing.SupportsFloat | typing.SupportsIndex) -> float:
    """
    The scale that the estimator takes an accelerometer to have whose mean specific force at rest has this norm (m/s^2): 1 if a bias explains it, or if it is no scale.
    """

def align_bscan(
    a: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[m, n]"],
    b: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[m, n]"],
    *,
    form: str = "cosine",
    min_overlap: typing.SupportsFloat | typing.SupportsIndex = 0.3,
    max_shift: typing.SupportsInt | typing.SupportsIndex = 0,
) -> tuple[Alignment, numpy.typing.NDArray[numpy.float64]]:
    """
    The same for B-scan windows of real values, (samples, traces).
    """

def align_curves(
    a: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[m, 1]"],
    b: typing.Annotated[numpy.typing.ArrayLike, numpy.float64, "[m, 1]"],
    *,
    min_overlap: typing.SupportsFloat | typing.SupportsIndex = 0.3,
    max_shift: typing.SupportsInt | typing.SupportsIndex = 0,
) -> tuple[Alignment, numpy.typing.NDArray[numpy.float64]]:
    """
    The same for two dominant energy curves, (traces,) each; see gpr/dec.h.
    """

def align_sfm(
    a: typing.Annotated[numpy.typing.ArrayLike, numpy.int8, "[m, n]"],
    b: typing.Annotated[numpy.typing.ArrayLike, numpy.int8, "[m, n]"],
    *,
    form: str = "cosine",
    min_overlap: typing.SupportsFloat | typing.SupportsIndex = 0.3,
    max_shift: typing.SupportsInt | typing.SupportsIndex = 0,
) -> tuple[Alignment, numpy.typing.NDArray[numpy.float64]]:
    """
    Alignment of two feature matrices (rows, columns), and the distances (2 limit + 1)
    for the shifts -limit..limit; see gpr/alignment.h.
    """

def band_pass(
    traces: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    sample_interval: typing.SupportsFloat | typing.SupportsIndex,
    low_hz: typing.SupportsFloat | typing.SupportsIndex = 150000000.0,
    high_hz: typing.SupportsFloat | typing.SupportsIndex = 900000000.0,
    length: typing.SupportsFloat | typing.SupportsIndex = 1e-08,
) -> numpy.typing.NDArray[numpy.float64]:
    """
    Zero-phase band-pass along each trace (..., samples).
    """

def build_sfm(
    depth: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    position: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    amplitude: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    *,
    rows: typing.SupportsInt | typing.SupportsIndex = 50,
    columns: typing.SupportsInt | typing.SupportsIndex = 50,
    depth_range: typing.SupportsFloat | typing.SupportsIndex,
    length: typing.SupportsFloat | typing.SupportsIndex,
    amplitude_scale: typing.SupportsFloat | typing.SupportsIndex,
) -> typing.Annotated[numpy.typing.NDArray[numpy.int8], "[m, n]"]:
    """
    Subsurface feature matrix, int8 (rows, columns), of peaks given as arrays of equal
    length; see gpr/sfm.h.
    """

def check_traces(
    traces: typing.Annotated[numpy.typing.ArrayLike, numpy.float32],
) -> numpy.typing.NDArray[numpy.int8]:
    """
    For each of (traces, samples): 0 good, 1 dead, 2 spiked.
    """

def coherence(
    times: typing.Annotated[numpy.typing.ArrayLike, numpy.int64],
    traces: typing.Annotated[numpy.typing.ArrayLike, numpy.float32],
    sample_interval: typing.SupportsFloat | typing.SupportsIndex,
    tick: typing.SupportsFloat | typing.SupportsIndex = 0.1,
) -> list[tuple[int, int, float, bool]]:
    """
    Path lengths that the coherence front end measures in (traces, samples) at `times` (ns): begin and end of each, ns; its length in decorrelation lengths of the ground; whether that is valid.
    """

def depth_of(
    travel_time_s: typing.SupportsFloat | typing.SupportsIndex,
    wave_speed: typing.SupportsFloat | typing.SupportsIndex,
) -> float:
    """
    Depth (m) of a reflector at a two-way travel time (s).
    """

def depth_row(
    depth: typing.SupportsFloat | typing.SupportsIndex,
    depth_range: typing.SupportsFloat | typing.SupportsIndex,
    rows: typing.SupportsInt | typing.SupportsIndex,
) -> int:
    """
    Row of a depth (m); -1 outside [0, depth_range).
    """

def describe_config(set: str | collections.abc.Sequence[str] = []) -> str:
    """
    Every key with unit and comment as YAML, at the defaults or with an override 'key=value' or several.
    """

def design_band_pass(
    low_hz: typing.SupportsFloat | typing.SupportsIndex,
    high_hz: typing.SupportsFloat | typing.SupportsIndex,
    sample_interval: typing.SupportsFloat | typing.SupportsIndex,
    length: typing.SupportsFloat | typing.SupportsIndex,
) -> list[float]:
    """
    Taps of the triangular-window band-pass of about `length` seconds; run both ways by band_pass.
    """

def dewow(
    traces: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    half_width: typing.SupportsInt | typing.SupportsIndex,
) -> numpy.typing.NDArray[numpy.float64]:
    """
    Each trace (..., samples) less its mean over 2 half_width + 1 samples.
    """

def dominant_energy_curve(
    traces: typing.Annotated[numpy.typing.ArrayLike, numpy.float32],
    *,
    half_width: typing.SupportsInt | typing.SupportsIndex = 5,
    first_row: typing.SupportsInt | typing.SupportsIndex = 20,
    jump_penalty: typing.SupportsFloat | typing.SupportsIndex = 0.01,
    smoothing: typing.SupportsInt | typing.SupportsIndex = 7,
) -> typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, 1]"]:
    """
    Row (samples) of the strongest reflector under each trace of (traces, samples),
    background removed; zeros where there is none; see gpr/dec.h.
    """

def envelope(
    trace: typing.Annotated[numpy.typing.ArrayLike, numpy.float32],
) -> numpy.typing.NDArray[numpy.float32]:
    """
    Hilbert envelope of a trace (samples,), its mean removed.
    """

def find_apexes(
    traces: typing.Annotated[numpy.typing.ArrayLike, numpy.float32],
    *,
    sample_interval: typing.SupportsFloat | typing.SupportsIndex,
    time_zero: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    pulse: typing.SupportsFloat | typing.SupportsIndex = 3e-09,
    first_time: typing.SupportsFloat | typing.SupportsIndex = 2e-09,
    least_widening: typing.SupportsFloat | typing.SupportsIndex = 0.0,
    most_widening: typing.SupportsFloat | typing.SupportsIndex = 0.0,
) -> list[Apex]:
    """
    Apexes of hyperbolas in (traces, samples), background removed, the strongest first;
    see gpr/sequential/apexes.h.
    """

def find_patch(
    memory: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[m, n]"],
    query: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[m, n]"],
    spacing: typing.SupportsFloat | typing.SupportsIndex,
    sample_interval: typing.SupportsFloat | typing.SupportsIndex,
    prior: typing.SupportsFloat | typing.SupportsIndex,
    bound: typing.SupportsFloat | typing.SupportsIndex,
    options: RevisitOptions = ...,
    filter_options: PatchFilterOptions = ...,
) -> RevisitMatch:
    """
    The same with options; returns a RevisitMatch.
    """

def gain_curve(
    samples: typing.SupportsInt | typing.SupportsIndex,
    rate: typing.SupportsFloat | typing.SupportsIndex,
    power: typing.SupportsFloat | typing.SupportsIndex,
    flat_after: typing.SupportsInt | typing.SupportsIndex,
) -> list[float]:
    """
    max(i, 1)^power exp(rate i) for sample i, constant from flat_after on.
    """

def install_map(folder: str, name: str, content: bytes) -> list[str]:
    """
    Writes a map file NAME.map into an estimator's folder. What it held before is kept
    under another name unless the new ground comes from it; returned is what to say of
    that. Raises FileError, also for the estimator's own ground while it runs.
    """

def iswt(
    details: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    approximation: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    wavelet: str,
) -> numpy.typing.NDArray[numpy.float64]:
    """
    The inverse of swt.
    """

def keep_details(
    traces: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    wavelet: str = "sym4",
    levels: typing.SupportsInt | typing.SupportsIndex = 4,
    threshold: typing.SupportsFloat | typing.SupportsIndex = 1.0,
) -> numpy.typing.NDArray[numpy.float64]:
    """
    Each trace (..., samples) with its approximation zeroed and its details soft-thresholded at threshold * sigma * sqrt(2 ln samples), sigma from the median absolute finest detail.
    """

def match_patch(
    memory: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[m, n]"],
    query: typing.Annotated[numpy.typing.ArrayLike, numpy.float32, "[m, n]"],
    spacing: typing.SupportsFloat | typing.SupportsIndex,
    sample_interval: typing.SupportsFloat | typing.SupportsIndex,
    prior: typing.SupportsFloat | typing.SupportsIndex,
    bound: typing.SupportsFloat | typing.SupportsIndex,
) -> tuple[float, bool, float]:
    """
    Place of the query in the memory; both are traces (columns, samples), `spacing` m apart.
    Returns (position of its centre in m from the memory's start, mirrored, score). The
    centre is expected within `bound` m of `prior` m.
    """

def remove_background(
    traces: typing.Annotated[numpy.typing.ArrayLike, numpy.float32],
    mode: str = "sequence",
    memory: typing.SupportsInt | typing.SupportsIndex = 400,
) -> numpy.typing.NDArray[numpy.float32]:
    """
    Traces (traces, samples) less their mean. mode: mean of the whole 'sequence'; 'running' mean with exponential forgetting over `memory` traces; or mean of the 'window' of the last `memory` traces.
    """

def standstills(
    times: typing.Annotated[numpy.typing.ArrayLike, numpy.int64],
    traces: typing.Annotated[numpy.typing.ArrayLike, numpy.float32],
    sample_interval: typing.SupportsFloat | typing.SupportsIndex,
    window: typing.SupportsFloat | typing.SupportsIndex = 0.6,
    tick: typing.SupportsFloat | typing.SupportsIndex = 0.1,
) -> numpy.typing.NDArray[numpy.int64]:
    """
    Standstills that the stationarity front end detects in (traces, samples) at `times` (ns): (n, 2), begin and end of each, ns. They overlap.
    """

def swt(
    trace: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    wavelet: str,
    levels: typing.SupportsInt | typing.SupportsIndex,
) -> tuple[numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64]]:
    """
    Stationary wavelet transform of (samples,), a multiple of 2^levels: details (levels, samples), finest first, and the last approximation (samples,).
    """

def track_time_zero(
    traces: typing.Annotated[numpy.typing.ArrayLike, numpy.float32],
    period: typing.SupportsFloat | typing.SupportsIndex,
    max_delay: typing.SupportsFloat | typing.SupportsIndex,
) -> tuple[numpy.typing.NDArray[numpy.float32], numpy.typing.NDArray[numpy.float64]]:
    """
    Traces (traces, samples) aligned on the direct wave, and the delay removed from each, samples. period: of the antenna's centre frequency, samples.
    """

def travel_time(
    sample: typing.SupportsFloat | typing.SupportsIndex,
    sample_interval_s: typing.SupportsFloat | typing.SupportsIndex,
    time_zero_s: typing.SupportsFloat | typing.SupportsIndex,
) -> float:
    """
    Two-way travel time (s) of a sub-sample index.
    """

RESET_ALL: str = "all"
