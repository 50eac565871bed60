"""The programs of `examples/` as modules, whose functions tests call."""

from importlib.util import module_from_spec, spec_from_file_location
from types import ModuleType

from pages import ROOT

EXAMPLES = ROOT / "examples"


def identifying(name: str) -> ModuleType:
    """`identify.py` of an example."""
    path = EXAMPLES / name / "identify.py"
    spec = spec_from_file_location(name.replace("-", "_"), path)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
