"""Builds the FMU of sprung/sprung.c: a stranger's body with a spring of its own to its anchor."""

from functools import cache
from pathlib import Path

from toy_fmu import build

SOURCE = Path(__file__).parent / "sprung" / "sprung.c"

FIXED = 'causality="parameter" variability="fixed"'


def _variable(reference: int, name: str, size: int, unit: str, rest: str) -> str:
    dimension = f'<Dimension start="{size}"/>' if size > 1 else ""
    return f'<Float64 name="{name}" valueReference="{reference}" unit="{unit}" {rest}>{dimension}</Float64>'


VARIABLES = (
    ("mass", 1, "kg", f'{FIXED} start="1"'),
    ("stiffness", 1, "N/m", f'{FIXED} start="1"'),
    ("damping", 1, "N.s/m", f'{FIXED} start="0"'),
    ("gravity", 3, "m/s2", f'{FIXED} start="0 0 0"'),
    ("initial_position", 3, "m", f'{FIXED} start="0 0 0"'),
    ("initial_velocity", 3, "m/s", f'{FIXED} start="0 0 0"'),
    ("anchor_position", 3, "m", 'causality="input" start="0 0 0"'),
    ("anchor_velocity", 3, "m/s", 'causality="input" start="0 0 0"'),
    ("position", 3, "m", 'causality="output"'),
    ("velocity", 3, "m/s", 'causality="output"'),
    ("anchor_force", 3, "N", 'causality="output"'),
    ("kinetic_energy", 1, "J", 'causality="output"'),
    ("potential_energy", 1, "J", 'causality="output"'),
    ("dissipation", 1, "W", 'causality="output"'),
    ("der(position)", 3, "m/s", 'causality="local" derivative="8"'),
    ("der(velocity)", 3, "m/s2", 'causality="local" derivative="9"'),
)
DEPENDENCIES = {8: "", 9: "", 10: "6 7 8 9", 11: "9", 12: "6 8", 13: "7 9"}

DESCRIPTION = f"""<fmiModelDescription fmiVersion="3.0" modelName="Sprung" instantiationToken="sprung">
<CoSimulation modelIdentifier="Sprung" canGetAndSetFMUState="true"/>
<UnitDefinitions>
  <Unit name="m"><BaseUnit m="1"/></Unit><Unit name="kg"><BaseUnit kg="1"/></Unit>
  <Unit name="m/s"><BaseUnit m="1" s="-1"/></Unit><Unit name="m/s2"><BaseUnit m="1" s="-2"/></Unit>
  <Unit name="N"><BaseUnit kg="1" m="1" s="-2"/></Unit><Unit name="N/m"><BaseUnit kg="1" s="-2"/></Unit>
  <Unit name="N.s/m"><BaseUnit kg="1" s="-1"/></Unit><Unit name="J"><BaseUnit kg="1" m="2" s="-2"/></Unit>
  <Unit name="W"><BaseUnit kg="1" m="2" s="-3"/></Unit>
</UnitDefinitions>
<ModelVariables>
  {"".join(_variable(reference, *variable) for reference, variable in enumerate(VARIABLES))}
  <Float64 name="time" valueReference="99" causality="independent"/>
</ModelVariables>
<ModelStructure>
  {"".join(f'<Output valueReference="{r}" dependencies="{d}"/>' for r, d in DEPENDENCIES.items())}
  <ContinuousStateDerivative valueReference="14" dependencies="9"/>
  <ContinuousStateDerivative valueReference="15" dependencies="6 7 8 9"/>
</ModelStructure>
</fmiModelDescription>"""

TERMINALS = """<fmiTerminalsAndIcons fmiVersion="3.0"><Terminals><Terminal name="anchor" matchingRule="bus">
  <TerminalMemberVariable variableName="anchor_position" memberName="position" variableKind="signal"/>
  <TerminalMemberVariable variableName="anchor_velocity" memberName="velocity" variableKind="signal"/>
  <TerminalMemberVariable variableName="anchor_force" memberName="force" variableKind="signal"/>
</Terminal></Terminals></fmiTerminalsAndIcons>"""


@cache
def sprung() -> Path:
    """Path of the FMU; it is compiled once per test session."""
    return build("Sprung", SOURCE, DESCRIPTION, TERMINALS, "3.0")
