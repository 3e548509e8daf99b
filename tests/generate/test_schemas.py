"""All generated XML validates against the schemas of the standards, as FMPy ships them."""

from pathlib import Path

import fmpy
import pytest
from generated import FOLDERS, each_unit, each_version, files

etree = pytest.importorskip("lxml.etree", reason="install it with: pip install lxml")

SCHEMAS = Path(fmpy.__file__).parent / "schema"
DOCUMENTS = {
    2: {"modelDescription.xml": "fmi2/fmi2ModelDescription.xsd"},
    3: {
        "modelDescription.xml": "fmi3/fmi3ModelDescription.xsd",
        "sources/buildDescription.xml": "fmi3/fmi3BuildDescription.xsd",
        "terminalsAndIcons/terminalsAndIcons.xml": "fmi3/fmi3TerminalsAndIcons.xsd",
    },
}
EACH = [(version, document) for version, documents in DOCUMENTS.items() for document in documents]


def errors(version: int, document: str, text: bytes) -> list[str]:
    schema = etree.XMLSchema(etree.parse(str(SCHEMAS / DOCUMENTS[version][document])))
    schema.validate(etree.fromstring(text))
    return [str(error) for error in schema.error_log]


@each_unit
@pytest.mark.parametrize(("version", "document"), EACH)
def test_every_document_validates(name, version, document):
    assert errors(version, document, files(name, version)[document]) == []


@pytest.mark.parametrize(("version", "document"), EACH)
def test_the_schema_would_find_an_unknown_attribute(version, document):
    text = files(next(iter(FOLDERS)), version)[document].replace(b"fmiVersion=", b'unheard="of" fmiVersion=', 1)
    assert len(errors(version, document, text)) == 1


@each_unit
@each_version
def test_no_xml_is_left_without_a_schema(name, version):
    without = {"extra/org.ulna/terminalsAndIcons.xml"}  # FMI 2 knows none: FMI 3's document, as an extra
    assert {file for file in files(name, version) if file.endswith(".xml")} - without == set(DOCUMENTS[version])


@each_unit
def test_terminals_of_fmi_2_validate_as_those_of_fmi_3(name):
    text = files(name, 2)["extra/org.ulna/terminalsAndIcons.xml"].replace(b'fmiVersion="2.0"', b'fmiVersion="3.0"')
    assert errors(3, "terminalsAndIcons/terminalsAndIcons.xml", text) == []
