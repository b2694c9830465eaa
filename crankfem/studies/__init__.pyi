"""Public names of this topic and their homes."""

from crankfem.analyses.study.response_fits import ResponseFits as ResponseFits
from crankfem.satellites.optimum.throw_search import SearchInterrupted as SearchInterrupted
from crankfem.satellites.optimum.throw_search import best_throw as best_throw
from regression.fits.fit import Fit as Fit
from regression.models.lookup import Lookups as Lookups
from regression.models.lookup import ReactionLookup as ReactionLookup
from regression.optimum import Limit as Limit
from regression.optimum import Optimum as Optimum
from regression.optimum import find_optimum as find_optimum
from regression.plans.designs import DesignChoice as DesignChoice
from regression.plans.factors import Factor as Factor
from regression.plans.plan import StudyPlan as StudyPlan
from regression.runs.study_table import StudyTable as StudyTable
