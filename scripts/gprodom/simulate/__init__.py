"""Drives, sensors and ground made up from a seed.

from gprodom.simulate import Spec, make_route, simulate, stream
drive = make_route("random", 12.0, 0.6, 4.0, stream(seed, "route"))
data = simulate(Spec(drive, ground=None), seed)
"""

from gprodom.random_streams import stream
from gprodom.simulate.routes import make_route
from gprodom.simulate.sequence import Simulated, Spec, simulate

__all__ = ["Simulated", "Spec", "make_route", "simulate", "stream"]
