"""Spacecraft in orbit, flown by Basilisk (bsk): its J2, tide, air, wheels and arms.

Basilisk is no dependency of the tests: it brings many libraries with it. In an
environment that has both,

    pip install bsk
    pytest -s -W ignore tests/oracles/test_orbit_in_basilisk.py
"""

# Basilisk is compiled, and its stubs do not say what it exports.
# pyright: reportAttributeAccessIssue=false, reportMissingImports=false

from dataclasses import dataclass, replace
from functools import cached_property
from importlib import import_module
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from orbident.estimation.identify import identify
from orbident.model.minimal_sets import minimal_sets
from orbident.orbits.earth import J2, MU, R_E
from orbident.orbits.orbit import Elements, Orbit
from orbident.robot.description import Joint, Robot, Wheel
from orbident.robot.parameters import from_mass_com_inertia
from orbident.robot.sensor_schema import declared_sensors
from orbident.simulation.flight import Driven, Hold, standing
from orbident.simulation.free_floating import BaseState
from orbident.simulation.free_flying import free_flying
from orbident.simulation.measure import Truth, measure_truth
from orbident.trajectories.environment import Environment

pytest.importorskip("Basilisk", reason="pip install bsk, which no other test needs")

MODULES = (
    *("spacecraft", "GravityGradientEffector", "spinningBodyOneDOFStateEffector"),
    *("svIntegrators", "sphericalHarmonicsGravityModel", "dragDynamicEffector"),
    *("reactionWheelStateEffector", "zeroWindModel"),
)
BSK = SimpleNamespace(
    **{name: import_module(f"Basilisk.simulation.{name}") for name in MODULES},
    **{
        name: import_module(f"Basilisk.utilities.{name}")
        for name in ("SimulationBaseClass", "macros", "simIncludeRW")
    },
    messaging=import_module("Basilisk.architecture.messaging"),
    gravity=import_module("Basilisk.utilities.simIncludeGravBody"),
)

DT, SAMPLE = 0.02, 0.1
"""s."""

DENSITY, AREA, COEFFICIENT, CENTRE = 3e-12, 10.0, 2.2, (0.5, 0.4, -0.2)

ORBIT = Elements(6.8e6, 0.9, 0.003, node=0.4, perigee=1.1, anomaly=0.3)
SPIN = np.array([0.01, 0.02, -0.015])
MRP = np.array([0.1, 0.2, -0.1])
HUB = 200.0, np.array([0.05, -0.02, 0.1])
I_HUB = np.array([[40.0, 1.0, 0.5], [1.0, 70.0, -1.0], [0.5, -1.0, 55.0]])
ARM = 12.0, np.array([0.5, 0.05, -0.1])
I_ARM = np.array([[0.3, 0.02, 0.01], [0.02, 1.5, -0.03], [0.01, -0.03, 1.6]])


def arms() -> tuple[Joint, ...]:
    turned = Rotation.from_euler("xyz", [0.4, -0.7, 1.1]).as_matrix()
    return (
        Joint("left", "revolute", 0, np.eye(3)[2], np.eye(3), np.array([0.6, 0.4, 0])),
        Joint("right", "revolute", 0, np.eye(3)[1], turned, np.array([-0.6, 0, 0.5])),
    )


def spacecraft(joints: tuple[Joint, ...]) -> Robot:
    """A hub with three wheels, and arms of one link."""
    links = [from_mass_com_inertia(*ARM, I_ARM) for _ in joints]
    return Robot(
        name="basilisk",
        motion="spatial",
        bodies=("base", *(joint.name for joint in joints)),
        joints=joints,
        theta=np.array([from_mass_com_inertia(*HUB, I_HUB), *links]),
        feature_point=np.zeros(3),
        wheels=tuple(Wheel(f"rw_{k}", np.eye(3)[k], 0.1, "free") for k in range(3)),
        orbit=Orbit(ORBIT),
    )


@dataclass
class Flight:
    """What Basilisk flies."""

    robot: Robot
    speed: float
    """Of each wheel, rad/s."""
    air: bool

    def __post_init__(self) -> None:
        self.sim = BSK.SimulationBaseClass.SimBaseClass()
        step = BSK.macros.sec2nano(DT)
        self.sim.CreateNewProcess("all").addTask(self.sim.CreateNewTask("all", step))
        self.craft = craft = BSK.spacecraft.Spacecraft()
        craft.setIntegrator(BSK.svIntegrators.svIntegratorRK4(craft))
        self._add(craft, 10)
        hub = craft.hub
        hub.mHub, com = HUB
        hub.r_BcB_B, hub.IHubPntBc_B = com[:, None].tolist(), I_HUB.tolist()
        self._around(craft)
        self.wheels = self._wheels(craft)
        self.arms = [self._arm(craft, joint) for joint in self.robot.joints]
        x = ORBIT.state()
        hub.r_CN_NInit, hub.v_CN_NInit = x[:3, None].tolist(), x[3:, None].tolist()
        hub.sigma_BNInit, hub.omega_BN_BInit = (
            MRP[:, None].tolist(),
            SPIN[:, None].tolist(),
        )
        self.seen = self._record(craft.scStateOutMsg)

    def _add(self, model, priority: int = 5) -> None:
        self.sim.AddModelToTask("all", model, priority)

    def _record(self, message):
        recorder = message.recorder(BSK.macros.sec2nano(SAMPLE))
        self._add(recorder, 1)
        return recorder

    def _around(self, craft) -> None:
        """The Earth with J2, its tide and its air."""
        factory = BSK.gravity.gravBodyFactory()
        earth = factory.createEarth()
        earth.isCentralBody, earth.mu, earth.radEquator = True, MU, R_E
        field = BSK.sphericalHarmonicsGravityModel.SphericalHarmonicsGravityModel()
        field.radEquator, field.muBody, field.maxDeg = R_E, MU, 2
        field.cBar = [[1.0], [0.0, 0.0], [-J2 / np.sqrt(5), 0.0, 0.0]]
        field.sBar = [[0.0], [0.0, 0.0], [0.0, 0.0, 0.0]]
        earth.gravityModel = field
        factory.addBodiesTo(craft)
        tide = BSK.GravityGradientEffector.GravityGradientEffector()
        tide.addPlanetName(earth.planetName)
        craft.addDynamicEffector(tide)
        self._add(tide)
        self.kept = [factory, tide]
        if self.air:
            self._air(craft)

    def _air(self, craft) -> None:
        payload = BSK.messaging.AtmoPropsMsgPayload()
        payload.neutralDensity = DENSITY
        density = BSK.messaging.AtmoPropsMsg().write(payload)
        wind = BSK.zeroWindModel.ZeroWindModel()
        wind.setPlanetOmega_N([0.0, 0.0, 7.2921159e-5])
        payload = BSK.messaging.SpicePlanetStateMsgPayload()
        middle = BSK.messaging.SpicePlanetStateMsg().write(payload)
        wind.planetPosInMsg.subscribeTo(middle)
        wind.addSpacecraftToModel(craft.scStateOutMsg)
        self._add(wind, 20)
        drag = BSK.dragDynamicEffector.DragDynamicEffector()
        drag.coreParams.projectedArea = AREA
        drag.coreParams.dragCoeff = COEFFICIENT
        drag.coreParams.comOffset = list(CENTRE)
        drag.atmoDensInMsg.subscribeTo(density)
        drag.windVelInMsg.subscribeTo(wind.envOutMsgs[0])
        craft.addDynamicEffector(drag)
        self._add(drag)
        self.kept += [density, middle, wind, drag]

    def _wheels(self, craft):
        factory = BSK.simIncludeRW.rwFactory()
        for wheel in self.robot.wheels:
            factory.create(
                "custom",
                wheel.axis.tolist(),
                Omega=self.speed * 30 / np.pi,
                Omega_max=6000.0,
                Js=wheel.inertia,
                u_max=1.0,
            )
        effector = BSK.reactionWheelStateEffector.ReactionWheelStateEffector()
        factory.addToSpacecraft("wheels", effector, craft)
        self._add(effector)
        self.kept.append(factory)
        self.kept.append(effector)
        return self._record(effector.rwSpeedOutMsg)

    def _arm(self, craft, joint: Joint):
        """It swings on a spring."""
        arm = BSK.spinningBodyOneDOFStateEffector.SpinningBodyOneDOFStateEffector()
        arm.mass, com = ARM
        arm.IPntSc_S, arm.r_ScS_S = I_ARM.tolist(), com[:, None].tolist()
        arm.dcm_S0B, arm.r_SB_B = joint.R_PJ.T.tolist(), joint.p_PJ[:, None].tolist()
        arm.sHat_S = joint.axis[:, None].tolist()
        arm.k, arm.c = (1.0 if joint.name == "left" else 2.0), 0.0
        arm.thetaInit, arm.thetaDotInit = 0.8, 0.2
        craft.addStateEffector(arm)
        self._add(arm)
        self.kept.append(arm)
        return self._record(arm.spinningBodyOutMsg)

    def fly(self, end: float) -> "Flight":
        self.sim.InitializeSimulation()
        self.sim.ConfigureStopTime(BSK.macros.sec2nano(end))
        self.sim.ExecuteSimulation()
        return self

    @cached_property
    def t(self) -> np.ndarray:
        return self.seen.times() * 1e-9

    @cached_property
    def attitude(self) -> np.ndarray:
        """MRPs turn inertial vectors into base axes: SciPy's, as turns of the base."""
        return Rotation.from_mrp(self.seen.sigma_BN).as_quat()

    @property
    def speeds(self) -> np.ndarray:
        return np.asarray(self.wheels.wheelSpeeds)[:, : len(self.robot.wheels)]


def test_a_spacecraft_without_arms_flies_as_ours_does():
    """Orbit, attitude, rates and wheels of ten minutes, in the tide and the air."""
    robot = spacecraft(())
    flown = Flight(robot, 20.0, air=True).fly(600.0)
    air = {"density": DENSITY, "area": AREA, "coefficient": COEFFICIENT}
    acts = {"gravity_gradient": True, "air_drag": {**air, "centre": [*CENTRE]}}
    base = BaseState(SPIN, flown.attitude[0], np.zeros(3), np.full(3, 20.0))
    nothing = np.zeros(0)

    def ours(acts: dict):
        return free_flying(
            robot,
            flown.t,
            standing(base, nothing),
            Hold(nothing),
            Driven(),
            environment=Environment.model_validate(acts),
        )

    mine, alone = ours(acts), ours({})
    place = Orbit(ORBIT).arc(0.0, 600.0).position(flown.t)
    off = np.abs(flown.seen.r_CN_N - place).max()
    moved = np.abs(flown.seen.omega_BN_B - alone.w).max()
    rate = np.abs(flown.seen.omega_BN_B - mine.w).max()
    turned = Rotation.from_quat(flown.attitude).inv() * Rotation.from_quat(
        mine.attitude
    )
    angle, speed = turned.magnitude().max(), np.abs(flown.speeds - mine.qd_rw).max()
    print(f"orbit {off:.2g} m, attitude {angle:.2g} rad, rate {rate:.2g} rad/s", moved)
    # The drag of 1.5 mN moves 200 kg by 1.4 m in ten minutes.
    assert off < 2.0
    assert moved > 1e-3
    # Basilisk holds the wind for a step, in which it turns by 2e-5 rad.
    assert rate < 2e-5 * moved
    assert speed < 2e-5 * moved * 2
    assert angle < 2e-5 * moved * 600


@pytest.fixture(scope="module")
def swinging() -> tuple[Robot, Flight]:
    """Two arms on springs, in the tide, for 150 s."""
    sensors = {
        "rate": 1 / SAMPLE,
        "gyro": {"angle_random_walk": 2e-6},
        "joints": {"position": 2e-5},
        "wheels": {"position": 2e-5},
        "attitude": {"angle": 2e-5},
        "position": {"std": 1e-4},
    }
    robot = replace(spacecraft(arms()), sensors=declared_sensors(sensors))
    return robot, Flight(robot, 60.0, air=False).fly(150.0)


@pytest.mark.parametrize("known", [True, False], ids=["orbit", "no orbit"])
def test_a_servicer_of_basilisk_is_identified(swinging, known: bool):
    """With its orbit; and without, a torque is named or it is refused, never wrong."""
    robot, flown = swinging
    seen = flown.seen
    q, qd = (
        np.column_stack([np.ravel(getattr(arm, name)) for arm in flown.arms])
        for name in ("theta", "thetaDot")
    )
    speeds = flown.speeds
    true = Truth(
        q=q,
        qd=qd,
        q_rw=CubicSpline(flown.t, speeds).antiderivative()(flown.t),
        qd_rw=speeds,
        gyro=np.asarray(seen.omega_BN_B),
        accelerometer=np.zeros((flown.t.size, 3)),
        attitude=flown.attitude,
        # From the CM, which falls freely.
        position=seen.r_BN_N - seen.r_CN_N,
        velocity=seen.v_BN_N - seen.v_CN_N,
    )
    robot = robot if known else replace(robot, orbit=None)
    beta = minimal_sets(robot).beta(robot.theta)
    z = []
    for seed in range(5):
        result = identify(robot, measure_truth(robot, flown.t, true, seed))
        z.append((result.base.values - beta) / result.base.std)
        groups = {fit.group for fit in result.disturbances.values()}
        print(seed, result.status, groups, np.abs(z[-1]).max().round(2))
        assert result.status == "ok" or not known, result.warnings
        if result.status == "ok":
            assert np.abs(z[-1]).max() < 5
            assert not groups if known else any("torque" in name for name in groups)
    print(f"rms {np.sqrt(np.nanmean(np.square(z))):.2f}")
