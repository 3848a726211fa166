"""Model against measurement: equation error, rollouts, and the noise floor beside them."""

from infotraj.comparing.comparison import Compared, Comparison, compare
from infotraj.comparing.equation_error import EquationError, equation_error
from infotraj.comparing.rollouts import Horizon, Rollouts, mean_errors, parse_horizons, rollouts
from infotraj.comparing.statistics import Difference, Statistics, difference, statistics

__all__ = [
    "Compared",
    "Comparison",
    "Difference",
    "EquationError",
    "Horizon",
    "Rollouts",
    "Statistics",
    "compare",
    "difference",
    "equation_error",
    "mean_errors",
    "parse_horizons",
    "rollouts",
    "statistics",
]
