"""A flat box spins about its middle axis, without torque or weight, and turns over and over (Dzhanibekov's effect).

Spin about the longest and the shortest side is stable; about the middle one, the smallest disturbance grows until the
box turns over. Energy and angular momentum stay as they are: nothing else is loaded, so this shows the solver alone.
"""

from ulna import Scene

UNTIL = 10.0
STEP = 0.001
MASTER = "gauss_seidel"

MASS = 0.2
SIDES = (0.30, 0.15, 0.02)  # m


def scene() -> Scene:
    """One box."""
    a, b, c = SIDES
    tumble = Scene("tumble")
    tumble.add(
        "RigidBody",
        "box",
        mass=MASS,
        inertia=[MASS / 12 * (b**2 + c**2), MASS / 12 * (a**2 + c**2), MASS / 12 * (a**2 + b**2)],
        gravity=[0.0, 0.0, 0.0],
        initial_angular_velocity=[0.01, 6.0, 0.0],
    )
    box = tumble["box"]
    tumble.record(box.position, box.orientation, box.angular_velocity, box.angular_momentum)
    tumble.record(box.kinetic_energy, box.potential_energy)
    return tumble
