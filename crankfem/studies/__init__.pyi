"""Public names of this topic and their homes."""

from crankfem.analyses.study.response_fits import ResponseFits as ResponseFits
from regression.fits.fits import Fit as Fit
from regression.models.lookup import Lookups as Lookups
from regression.models.optimum import Optimum as Optimum
from regression.models.optimum import find_optimum as find_optimum
from regression.models.optimum_limits import Limit as Limit
from regression.models.reaction_lookup import ReactionLookup as ReactionLookup
from regression.runs.study_table import StudyTable as StudyTable
