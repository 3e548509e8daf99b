"""The README's own example runs as it stands."""

import re
from pathlib import Path

import pytest

README = Path(__file__).parents[1] / "README.md"


def test_example_of_the_readme_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    example = re.search(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)[1]
    names: dict = {}
    exec(example, names)
    # after 1 s: 5 t - g t^2 / 2 up, and the distance to the nearest point of the ball
    height = 5.0 - 9.80665 / 2
    assert names["results"]["ball.position"][-1][2] == pytest.approx(height, abs=1e-12)
    assert (tmp_path / "throw.csv").read_text().startswith("time [s],ball.position[1] [m]")


def test_links_of_the_readme_lead_somewhere() -> None:
    links = re.findall(r"\]\(([^)#]+)\)", README.read_text(encoding="utf-8"))
    missing = [link for link in links if "://" not in link and not (README.parent / link).exists()]
    assert len(links) > 5
    assert not missing
