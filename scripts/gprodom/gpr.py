"""Radar processing on numpy arrays: the stages of the C++ front ends, each usable alone.

Traces are arrays (traces, samples), oldest first; feature matrices (rows of depth, columns along
the track). Every function's docstring and its C++ header (src/gpr/) state units.
"""

from gprodom._core import Alignment as Alignment
from gprodom._core import DetailsRetention as DetailsRetention
from gprodom._core import FilterConfig as FilterConfig
from gprodom._core import GlobalMatch as GlobalMatch
from gprodom._core import GlobalSearch as GlobalSearch
from gprodom._core import GlobalSearchOptions as GlobalSearchOptions
from gprodom._core import GprTrace as GprTrace
from gprodom._core import PatchFilter as PatchFilter
from gprodom._core import PatchFilterOptions as PatchFilterOptions
from gprodom._core import PatchMatcher as PatchMatcher
from gprodom._core import PathLength as PathLength
from gprodom._core import Peak as Peak
from gprodom._core import PeakCounts as PeakCounts
from gprodom._core import PeakExtractor as PeakExtractor
from gprodom._core import PeakOptions as PeakOptions
from gprodom._core import RevisitMatch as RevisitMatch
from gprodom._core import RevisitOptions as RevisitOptions
from gprodom._core import RevisitSearch as RevisitSearch
from gprodom._core import RevisitSearchOptions as RevisitSearchOptions
from gprodom._core import Sight as Sight
from gprodom._core import Standstill as Standstill
from gprodom._core import TrackDisplacement as TrackDisplacement
from gprodom._core import align_bscan as align_bscan
from gprodom._core import align_curves as align_curves
from gprodom._core import align_sfm as align_sfm
from gprodom._core import band_pass as band_pass
from gprodom._core import build_sfm as build_sfm
from gprodom._core import check_traces as check_traces
from gprodom._core import coherence as coherence
from gprodom._core import depth_of as depth_of
from gprodom._core import depth_row as depth_row
from gprodom._core import design_band_pass as design_band_pass
from gprodom._core import dewow as dewow
from gprodom._core import dominant_energy_curve as dominant_energy_curve
from gprodom._core import envelope as envelope
from gprodom._core import find_apexes as find_apexes
from gprodom._core import find_patch as find_patch
from gprodom._core import gain_curve as gain_curve
from gprodom._core import iswt as iswt
from gprodom._core import keep_details as keep_details
from gprodom._core import match_patch as match_patch
from gprodom._core import remove_background as remove_background
from gprodom._core import standstills as standstills
from gprodom._core import swt as swt
from gprodom._core import track_time_zero as track_time_zero
from gprodom._core import travel_time as travel_time
