"""MuJoCo's ray at the poses of the sensor's chart: what a range finder is in most simulators."""

from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from typing import ClassVar

import numpy as np

from .sensor_truths import Pose


class Rays:
    """A MuJoCo model of a pose, and rays along the sensor's axis."""

    NAME: ClassVar[str] = "MuJoCo mj_ray"

    def __init__(self, pose: Pose):
        """Builds the model; raises ModuleNotFoundError where MuJoCo is not installed."""
        import mujoco

        self._mujoco = mujoco
        text = f"<mujoco><worldbody>{''.join(_geoms(pose))}</worldbody></mujoco>"
        self._model = mujoco.MjModel.from_xml_string(text)
        self._data = mujoco.MjData(self._model)
        mujoco.mj_forward(self._model, self._data)

    def length(self) -> float:
        """To the first surface on the axis, m; infinite if there is none."""
        lengths = np.zeros(1)
        self._rays(1, lengths)()
        return float(lengths[0]) if lengths[0] >= 0 else np.inf

    def many(self, count: int) -> Callable[[], None]:
        """A call of as many rays at once."""
        return self._rays(count, np.zeros(count))

    def _rays(self, count: int, lengths: np.ndarray) -> Callable[[], None]:
        axes, hit = np.tile([1.0, 0.0, 0.0], count), np.zeros(count, np.int32)
        where = self._model, self._data, np.zeros(3), axes
        return partial(self._mujoco.mj_multiRay, *where, None, True, -1, hit, lengths, None, count, 1e3)


def rays(pose: Pose) -> Rays | None:
    """None where MuJoCo is not installed."""
    return Rays(pose) if find_spec("mujoco") else None


def _geoms(pose: Pose) -> list[str]:
    found = []
    values = {name: " ".join(map(repr, np.ravel(value).tolist())) for name, value in pose.inputs.items()}
    if "plane_normal" in values:
        found.append(f'type="plane" size="0 0 1" pos="{values["plane_point"]}" zaxis="{values["plane_normal"]}"')
    if "sphere_radius" in values:
        found.append(f'type="sphere" size="{values["sphere_radius"]}" pos="{values["sphere_center"]}"')
    if "capsule_1_radius" in values:
        ends = f"{values['capsule_1_start']} {values['capsule_1_end']}"
        found.append(f'type="capsule" size="{values["capsule_1_radius"]}" fromto="{ends}"')
    if "box_size" in values:
        half = " ".join(map(repr, (np.ravel(pose.inputs["box_size"]) / 2).tolist()))
        place = f'pos="{values["box_center"]}" quat="{values["box_orientation"]}"'
        found.append(f'type="box" size="{half}" {place}')
    return [f"<geom {shape}/>" for shape in found]
