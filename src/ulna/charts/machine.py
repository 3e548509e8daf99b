"""What measured times belong to."""

import platform
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from .driver import compiler

PACKAGES = ("ulna", "mujoco", "scipy", "casadi", "ecospy", "fmpy", "numpy", "libigl", "usd-core")


def machine() -> dict[str, str]:
    """Processor, system, versions and the time now; raises FileNotFoundError without a C compiler."""
    versions = {}
    for package in PACKAGES:
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            continue
    return {
        "processor": processor(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "compiler": Path(compiler()).name,
        "time": datetime.now(UTC).isoformat(timespec="seconds"),
        **versions,
    }


def processor() -> str:
    """Name of the processor, as far as the system gives it."""
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
