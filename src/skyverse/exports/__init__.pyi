"""The face of exports; see `skyverse.exports`."""

from .export import export as export
from .fleet_routes import routes as routes
from .fleet_routes import routes_apart as routes_apart
from .leg_space import LegSpace as LegSpace
from .legs import LegChecker as LegChecker
from .legs import refused as refused
from .requirements import ExportOptions as ExportOptions
from .route import Route as Route
from .separation import USUAL_TOLERANCE as USUAL_TOLERANCE
from .separation import Apart as Apart
from .separation import timed_path as timed_path
from .verdicts import ExportCertificate as ExportCertificate
from .verdicts import verdict_table as verdict_table
from .way_home import UNPROVEN as UNPROVEN
from .way_home import WAYS as WAYS
