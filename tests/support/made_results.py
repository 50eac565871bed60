"""Results as `identify` gives them, of base parameters that are made up."""

from dataclasses import replace

import numpy as np

from orbident.estimation.checks import Check
from orbident.estimation.quantities import NO_ROUTES, BaseSet, EstimatedSet, TotalMass
from orbident.estimation.result import Result
from orbident.model.formulas import formulas_of, nominal_parameters
from orbident.model.minimal_sets import minimal_sets
from orbident.robot.description import Robot
from orbident.robot.parameters import Structure

REFUSED = Check("scale", "do not trust", "mass: no scale", "spin a wheel up")

NONE = EstimatedSet((), (), np.zeros(0), np.zeros(0), np.zeros(0))


def made_result(robot: Robot, beta: np.ndarray, covariance: np.ndarray) -> Result:
    """A result with these base parameters; `pi` and `phi` are left out."""
    sets = minimal_sets(robot)
    words = formulas_of(robot, sets).base
    nominal = nominal_parameters(robot, sets).base
    std = np.sqrt(np.diag(covariance))
    return Result(
        robot=robot,
        method="maximum-likelihood",
        initial_momentum="unknown",
        checks=(),
        mass=TotalMass(float(beta[0]), float(std[0]), NO_ROUTES),
        pi=NONE,
        phi=NONE,
        base=BaseSet(words.names, words.formulas, beta, std, nominal, covariance),
        condition_number={},
        residual={},
        biases={},
        clocks={},
        rejected={},
        origins={},
        samples=1601,
        elapsed_s=1.0,
        versions={},
        covariance=np.zeros((0, 0)),
    )


def without(result: Result, *names: str) -> Result:
    """The same result, where these base parameters are not determined."""
    lost = np.isin(result.base.names, names)
    assert lost.sum() == len(names)
    values, std = (
        np.where(lost, np.nan, numbers)
        for numbers in (result.base.values, result.base.std)
    )
    C = np.where(np.logical_or.outer(lost, lost), np.nan, result.base_covariance)
    base = replace(result.base, values=values, std=std, covariance=C)
    return replace(result, base=base)


def freed(robot: Robot, *bodies: str) -> Robot:
    """The same robot, where nothing is known of these bodies; its file too."""
    kept = [body for body in robot.structure if body not in bodies]
    declared = robot.document.get("structure", {})
    document = {**robot.document, "structure": {k: declared[k] for k in kept}}
    structure = {k: robot.structure[k] for k in kept}
    return replace(robot, structure=structure, document=document)


def known(robot: Robot, **structure: Structure) -> Robot:
    """The same robot, where this is known of these bodies beside what was."""
    return replace(robot, structure={**robot.structure, **structure})


def joined(robot: Robot, body: str, theta_t: np.ndarray) -> Robot:
    """The same robot, holding a body with these parameters in the frame of `body`."""
    theta = robot.theta.copy()
    theta[robot.bodies.index(body)] += theta_t
    return replace(robot, theta=theta)


def correlated(robot: Robot, seed: int, size: float) -> np.ndarray:
    """A covariance; deviations are about `size` times the mass, in SI units."""
    random = np.random.default_rng(seed)
    n = len(minimal_sets(robot).base.T)
    root = np.eye(n) + 0.3 * random.standard_normal((n, n))
    std = size * robot.mass * random.uniform(0.3, 1.0, n)
    return np.outer(std, std) * (root @ root.T)


def exact_result(robot: Robot, seed: int = 0, size: float = 1e-9) -> Result:
    """The truth, with such a covariance."""
    beta = minimal_sets(robot).beta(robot.theta)
    return made_result(robot, beta, correlated(robot, seed, size))
