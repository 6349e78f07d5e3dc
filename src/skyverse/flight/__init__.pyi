"""The face of simulated flights; see `skyverse.flight`."""

from .commands import HOVER_SECONDS as HOVER_SECONDS
from .commands import commands_to as commands_to
from .commands import thrust_along as thrust_along
from .disturbances import FOOT as FOOT
from .disturbances import draw as draw
from .disturbances import gust_scales as gust_scales
from .disturbances import gusts as gusts
from .judge import passings as passings
from .judge import strayed as strayed
from .runs import fly_run as fly_run
from .runs import prepare as prepare
from .simulator import RungeKutta as RungeKutta
from .simulator import WindObserver as WindObserver
from .simulator import simulate as simulate
from .simulator import simulate_in_rotorpy as simulate_in_rotorpy
from .until_safe import farther as farther
from .until_safe import is_no_worse as is_no_worse
from .until_safe import slowed as slowed
from .vehicle import VEHICLES as VEHICLES
from .vehicle import vehicle_of as vehicle_of
