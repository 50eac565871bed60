"""The site builds without a warning, and needs no other host."""

import logging
import re
from pathlib import Path
from typing import cast

import pytest
import typer
from typer.core import TyperGroup

from orbident.cli.verbs import app

ROOT = Path(__file__).parents[2]
# What a page loads by itself; links may lead elsewhere.
LOADED = re.compile(
    r"""<(?:script|img|iframe|source)[^>]*\ssrc=["']?(https?:)?//"""
    r"""|<link[^>]*rel=["']?(?:stylesheet|preload|preconnect|icon)[^>]*href=["']?"""
    r"""(?:https?:)?//"""
)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("material", reason="mkdocs-material is not installed")
    from mkdocs.commands.build import build
    from mkdocs.config import load_config

    folder = tmp_path_factory.mktemp("site")
    # Strict: a warning ends it with an exception.
    config = load_config(str(ROOT / "mkdocs.yml"), site_dir=str(folder), strict=True)
    try:
        build(config)
    finally:
        # mkdocs keeps handlers for its warnings.
        logging.getLogger("mkdocs").handlers.clear()
    return folder


@pytest.mark.filterwarnings("default")
def test_every_page_is_there(site: Path):
    for page in (ROOT / "docs").rglob("*.md"):
        built = site / page.relative_to(ROOT / "docs").with_suffix("")
        assert (built / "index.html").exists() or page.name == "index.md"


@pytest.mark.filterwarnings("default")
def test_equations_and_names_are_in_it(site: Path):
    theory = (site / "theory" / "index.html").read_text()
    assert theory.count("<math") >= 9
    api = (site / "api" / "index.html").read_text()
    import orbident

    for name in dir(orbident):
        assert f"orbident.{name}" in api or f">{name}<" in api, name


@pytest.mark.filterwarnings("default")
def test_every_verb_and_option_is_in_it(site: Path):
    page = (site / "command-line" / "index.html").read_text()
    group = cast("TyperGroup", typer.main.get_command(app))
    for name, verb in group.commands.items():
        assert f">{name}<" in page
        for option in verb.params:
            assert all(flag in page for flag in option.opts if flag.startswith("-"))
    assert "<!-- verbs -->" not in page


@pytest.mark.filterwarnings("default")
def test_nothing_is_loaded_from_elsewhere(site: Path):
    for page in site.rglob("*.html"):
        assert not LOADED.search(page.read_text()), page
    for sheet in site.rglob("*.css"):
        assert not re.search(r"url\(['\"]?(https?:)?//", sheet.read_text()), sheet
