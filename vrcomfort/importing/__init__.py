"""Other labs' files: read in any layout, understood through a mapping, written as a study."""

from vrcomfort.importing.convert import import_files
from vrcomfort.importing.mapping import LabMapping, MappingFile, load_mapping, parse_mapping
from vrcomfort.importing.preview import preview
from vrcomfort.importing.study import write_study

__all__ = [
    "LabMapping",
    "MappingFile",
    "import_files",
    "load_mapping",
    "parse_mapping",
    "preview",
    "write_study",
]
