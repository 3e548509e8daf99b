"""What the READMEs say to run runs as it stands, and their links lead somewhere."""

import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from ulna.cli import app

CHECKOUT = Path(__file__).parents[1]
README = CHECKOUT / "README.md"
READMES = [README, *sorted(CHECKOUT.glob("fmus/*/README.md")), *sorted(CHECKOUT.glob("examples/*/README.md"))]
RUNS = sorted(
    {
        run.strip()
        for path in READMES
        for run in re.findall(r"ulna (run [a-z][^`#\n]*)", path.read_text(encoding="utf-8"))
    }
)


def test_example_of_the_readme_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    example = re.search(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)[1]
    names: dict = {}
    exec(example, names)
    # after 1 s: 5 t - g t^2 / 2 up, and the distance to the nearest point of the ball
    height = 5.0 - 9.80665 / 2
    assert names["results"]["ball.position"][-1][2] == pytest.approx(height, abs=1e-12)
    assert (tmp_path / "throw.csv").read_text().startswith("time [s],ball.position[1] [m]")


@pytest.mark.parametrize("run", RUNS)
def test_scenes_run_as_the_readmes_say(run: str, tmp_path: Path) -> None:
    """Shortly: the last --until counts."""
    result = CliRunner().invoke(app, [*shlex.split(run), "--until", "0.02", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output


def test_links_of_the_readmes_lead_somewhere() -> None:
    links = [
        (path, link) for path in READMES for link in re.findall(r"\]\(([^)#]+)\)", path.read_text(encoding="utf-8"))
    ]
    assert len(links) > 5
    assert not [link for path, link in links if "://" not in link and not (path.parent / link).exists()]
