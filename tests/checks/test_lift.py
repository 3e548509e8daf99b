"""The C on symbols: what is traced is what ships, and what cannot be traced is refused with its reason."""

from pathlib import Path

import casadi as ca
import pytest
from casadi import SX

from ulna import fmu
from ulna.checks import lift as lifting
from ulna.checks.needs import MissingNeedError, require_modules

REPOSITORY = Path(__file__).parents[2]


@pytest.fixture
def sources(tmp_path):
    return lifting.extract(fmu("RigidBody"), tmp_path)


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def test_what_is_traced_is_the_file_of_the_repository(sources):
    for name in ("equations.h", "solvers.c"):
        assert (sources / name).read_bytes() == (REPOSITORY / "fmus" / "rigid_body" / name).read_bytes()


def test_the_traced_body_spins_as_eulers_top(sources):
    lifted = lifting.lift(sources)
    values = {
        "mass": SX(2),
        "inertia": SX([1, 2, 4]),
        "orientation": SX([1, 0, 0, 0]),
        "angular_momentum": SX([3, 4, 8]),
        **{name: SX.zeros(3) for name in ("torque", "base_torque", "tip_torque", "base_force", "tip_force", "force")},
        "gravity": SX.zeros(3),
    }
    rate = ca.evalf(lifted.equations(values)["angular_velocity"])
    acceleration = ca.evalf(lifted.equations(values)["angular_acceleration"])
    # w = L / I; I dw/dt = L x w where the body axes are those of the world: exact in binary
    assert rate.nonzeros() == [3.0, 2.0, 2.0]
    assert acceleration.nonzeros() == [-8.0, 9.0, -1.5]


def test_names_that_are_not_given_stay_free(sources):
    lifted = lifting.lift(sources)
    velocity = lifted.equations({"mass": SX(2)})["velocity"]
    assert {str(symbol) for symbol in ca.symvar(velocity)} == {f"linear_momentum_{k}" for k in range(3)}
    with pytest.raises(KeyError):
        lifted.equations({})["wings"]


def test_states_and_solvers_are_those_of_the_unit(sources):
    lifted = lifting.lift(sources)
    assert lifted.states == ["position", "orientation", "linear_momentum", "angular_momentum"]
    # the others iterate or choose their steps: no single formula to trace
    assert set(lifted.solvers) == {"explicit_euler", "notes", "splitting", "rk4"} < set(lifted.header.solvers)


def test_a_change_of_the_sources_is_traced_anew(sources, cache):
    before = lifting.lift(sources).equations({})["kinetic_energy"]
    path = sources / "equations.h"
    path.write_text(path.read_text().replace("body->kinetic_energy = 0.5 *", "body->kinetic_energy = 0.25 *"))
    after = lifting.lift(sources).equations({})["kinetic_energy"]
    symbols = {s.name(): 1.0 for s in ca.symvar(before)}
    half = [ca.Function("f", ca.symvar(e), [e])(*symbols.values()) for e in (before, after)]
    assert float(half[1]) == float(half[0]) / 2


def test_c_with_a_branch_on_symbols_is_refused_with_the_compilers_words(sources, cache):
    path = sources / "equations.h"
    path.write_text(
        path.read_text().replace("return loads;", "if (loads.force.x > 0.0) return loads;\n    return loads;", 1)
    )
    with pytest.raises(lifting.LiftError, match=r"(?s)failed.*equations\.h"):
        lifting.lift(sources)


def test_an_fmu_without_sources_is_refused(tmp_path):
    import zipfile

    path = tmp_path / "bare.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", "<fmiModelDescription/>")
    with pytest.raises(lifting.LiftError, match="no sources"):
        lifting.extract(path, tmp_path)


def test_a_missing_compiler_is_named_with_the_remedy(sources, cache, monkeypatch):
    monkeypatch.setenv("CXX", "no-such-compiler")
    with pytest.raises(MissingNeedError, match=r"no-such-compiler.*apt install g\+\+"):
        lifting.lift(sources)


def test_missing_packages_are_named_with_the_remedy(monkeypatch):
    monkeypatch.setattr("ulna.checks.needs.find_spec", lambda name: None)
    with pytest.raises(MissingNeedError, match=r"casadi and mpmath.*ulna\[test\]"):
        require_modules()
