"""Builds the toy FMU of toy/toy.c, for FMI 2.0 and 3.0, as a stranger's FMU on which the master is tested."""

import re
import subprocess
import tempfile
import zipfile
from functools import cache
from pathlib import Path

import fmpy

SOURCE = Path(__file__).parent / "toy" / "toy.c"
HEADERS = Path(fmpy.__file__).parent / "c-code"

UNITS = """<UnitDefinitions>
  <Unit name="m"><BaseUnit m="1"/></Unit><Unit name="metre"><BaseUnit m="1"/></Unit>
  <Unit name="mm"><BaseUnit m="1" factor="0.001"/></Unit><Unit name="1/s"><BaseUnit s="-1"/></Unit>
</UnitDefinitions>"""

TERMINALS = """<fmiTerminalsAndIcons fmiVersion="3.0"><Terminals>
  <Terminal name="plug" matchingRule="bus">
    <TerminalMemberVariable variableName="x" memberName="position" variableKind="signal"/>
    <TerminalMemberVariable variableName="count" memberName="count" variableKind="signal"/>
  </Terminal>
  <Terminal name="socket" matchingRule="bus">
    <TerminalMemberVariable variableName="u" memberName="position" variableKind="signal"/>
    <TerminalMemberVariable variableName="next_count" memberName="count" variableKind="signal"/>
  </Terminal>
</Terminals></fmiTerminalsAndIcons>"""

DESCRIPTION = {
    "3.0": f"""<fmiModelDescription fmiVersion="3.0" modelName="Toy" instantiationToken="toy">
<CoSimulation modelIdentifier="Toy" canGetAndSetFMUState="true" canSerializeFMUState="true"/>
{UNITS}
<TypeDefinitions><EnumerationType name="Mode"><Item name="plain" value="1"/><Item name="doubled" value="2"/>
</EnumerationType></TypeDefinitions>
<ModelVariables>
  <Float64 name="gain" valueReference="0" causality="parameter" variability="fixed" start="1" unit="1/s"/>
  <Enumeration name="mode" valueReference="1" declaredType="Mode" causality="parameter" variability="fixed" start="1"/>
  <Float64 name="u" valueReference="2" causality="input" start="0 0 0" unit="m"><Dimension start="3"/></Float64>
  <Float64 name="x" valueReference="3" causality="output" unit="m"><Dimension start="3"/></Float64>
  <Float64 name="y" valueReference="4" causality="output" unit="metre"><Dimension start="3"/></Float64>
  <Boolean name="flag" valueReference="5" causality="input" start="false"/>
  <Boolean name="not_flag" valueReference="6" causality="output"/>
  <Int32 name="count" valueReference="7" causality="input" start="0"/>
  <Int32 name="next_count" valueReference="8" causality="output"/>
  <UInt64 name="size" valueReference="9" causality="structuralParameter" variability="fixed" start="2"/>
  <Float64 name="ramp" valueReference="10" causality="local"><Dimension valueReference="9"/></Float64>
  <Float64 name="time" valueReference="99" causality="independent"/>
</ModelVariables>
<ModelStructure>
  <Output valueReference="3" dependencies=""/><Output valueReference="4" dependencies="2"/>
  <Output valueReference="6" dependencies="5"/><Output valueReference="8" dependencies="7"/>
  <InitialUnknown valueReference="3" dependencies=""/><InitialUnknown valueReference="4" dependencies="2"/>
  <InitialUnknown valueReference="6" dependencies="5"/><InitialUnknown valueReference="8" dependencies="7"/>
</ModelStructure>
</fmiModelDescription>""",
    "2.0": f"""<fmiModelDescription fmiVersion="2.0" modelName="Toy" guid="toy" variableNamingConvention="structured">
<CoSimulation modelIdentifier="Toy" canGetAndSetFMUstate="true" canSerializeFMUstate="true"/>
{UNITS}
<TypeDefinitions><SimpleType name="Mode"><Enumeration><Item name="plain" value="1"/><Item name="doubled" value="2"/>
</Enumeration></SimpleType></TypeDefinitions>
<ModelVariables>
  <ScalarVariable name="gain" valueReference="0" causality="parameter" variability="fixed"><Real start="1" unit="1/s"/>
  </ScalarVariable>
  <ScalarVariable name="mode" valueReference="1" causality="parameter" variability="fixed">
    <Enumeration declaredType="Mode" start="1"/></ScalarVariable>
  <ScalarVariable name="u[1]" valueReference="10" causality="input"><Real start="0" unit="m"/></ScalarVariable>
  <ScalarVariable name="u[2]" valueReference="11" causality="input"><Real start="0" unit="m"/></ScalarVariable>
  <ScalarVariable name="u[3]" valueReference="12" causality="input"><Real start="0" unit="m"/></ScalarVariable>
  <ScalarVariable name="x[1]" valueReference="20" causality="output"><Real unit="m"/></ScalarVariable>
  <ScalarVariable name="x[2]" valueReference="21" causality="output"><Real unit="m"/></ScalarVariable>
  <ScalarVariable name="x[3]" valueReference="22" causality="output"><Real unit="m"/></ScalarVariable>
  <ScalarVariable name="y[1]" valueReference="30" causality="output"><Real unit="metre"/></ScalarVariable>
  <ScalarVariable name="y[2]" valueReference="31" causality="output"><Real unit="metre"/></ScalarVariable>
  <ScalarVariable name="y[3]" valueReference="32" causality="output"><Real unit="metre"/></ScalarVariable>
  <ScalarVariable name="flag" valueReference="5" causality="input" variability="discrete"><Boolean start="false"/>
  </ScalarVariable>
  <ScalarVariable name="not_flag" valueReference="6" causality="output" variability="discrete"><Boolean/>
  </ScalarVariable>
  <ScalarVariable name="count" valueReference="7" causality="input" variability="discrete"><Integer start="0"/>
  </ScalarVariable>
  <ScalarVariable name="next_count" valueReference="8" causality="output" variability="discrete"><Integer/>
  </ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs>
  <Unknown index="6" dependencies=""/><Unknown index="7" dependencies=""/><Unknown index="8" dependencies=""/>
  <Unknown index="9" dependencies="3"/><Unknown index="10" dependencies="4"/><Unknown index="11" dependencies="5"/>
  <Unknown index="13" dependencies="12"/><Unknown index="15" dependencies="14"/>
</Outputs><InitialUnknowns>
  <Unknown index="6" dependencies=""/><Unknown index="7" dependencies=""/><Unknown index="8" dependencies=""/>
  <Unknown index="9" dependencies="3"/><Unknown index="10" dependencies="4"/><Unknown index="11" dependencies="5"/>
  <Unknown index="13" dependencies="12"/><Unknown index="15" dependencies="14"/>
</InitialUnknowns></ModelStructure>
</fmiModelDescription>""",
}


@cache
def toy(version: str = "3.0") -> Path:
    """Path of the toy's FMU; it is compiled once per test session."""
    return build("Toy", SOURCE, DESCRIPTION[version], TERMINALS, version)


def build(name: str, source: Path, description: str, terminals: str, version: str) -> Path:
    """Compiles an FMU from one C file, with a stub for every function of the standard that it lacks."""
    folder = Path(tempfile.mkdtemp(prefix=f"{name.lower()}-"))
    header = (HEADERS / f"fmi{version[0]}Functions.h").read_text()
    names = re.findall(rf"TYPE\s+(fmi{version[0]}\w+);", header)
    stubs = folder / "stubs.c"
    stubs.write_text("".join(f"__attribute__((weak)) int {stub}(void) {{ return 0; }}\n" for stub in names))
    library = folder / f"{name}.so"
    options = ["-shared", "-fPIC", "-O2", "-w", f"-DFMI_VERSION={version[0]}", f"-I{HEADERS}"]
    subprocess.run(["cc", *options, str(source), str(stubs), "-o", str(library), "-lm"], check=True)
    platform = fmpy.platform_tuple if version == "3.0" else fmpy.platform
    fmu = folder / f"{name}.fmu"
    with zipfile.ZipFile(fmu, "w") as archive:
        archive.writestr("modelDescription.xml", description)
        archive.writestr("terminalsAndIcons/terminalsAndIcons.xml", terminals)
        archive.write(library, f"binaries/{platform}/{name}{fmpy.sharedLibraryExtension}")
    return fmu
