"""The documents' Python code runs as it stands; what takes long has at least imports that exist."""

import ast
import builtins
import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
FENCED = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
INDENTED = re.compile(r"(?:^ {4}.*\n)+", re.MULTILINE)
LONG = "periodic_orbits|branch|simulate"  # what takes many seconds
#: Blocks in these documents begin from a file that the reader has written before.
NEEDS_FILES = {"your-rod.md"}


def _blocks():
    for path in sorted(ROOT.glob("docs/*.md")):
        text = path.read_text(encoding="utf-8")
        indented = (
            re.sub("^ {4}", "", b, flags=re.MULTILINE) for b in INDENTED.findall(FENCED.sub("", text))
        )
        code = FENCED.findall(text) + [b for b in indented if re.match(r"(from|import) \w", b)]
        yield from (pytest.param(path.name, block, id=f"{path.name}-{i}") for i, block in enumerate(code))


BLOCKS = list(_blocks())


def test_there_are_blocks_to_run():
    assert len(BLOCKS) >= 5


@pytest.mark.parametrize(("name", "block"), BLOCKS)
def test_what_a_block_imports_exists(name, block):
    for node in ast.walk(ast.parse(block)):
        if isinstance(node, ast.ImportFrom):
            module = importlib.import_module(node.module or "")
            assert [a.name for a in node.names if not hasattr(module, a.name)] == []
        elif isinstance(node, ast.Import):
            for alias in node.names:
                importlib.import_module(alias.name)


@pytest.mark.parametrize(
    ("name", "block"),
    [p for p in BLOCKS if not re.search(LONG, str(p.values[1])) and p.values[0] not in NEEDS_FILES],
)
def test_a_short_block_runs(name, block, capsys):
    exec(compile(block, name, "exec"), {})


@pytest.mark.parametrize(("name", "block"), BLOCKS)
def test_a_block_uses_only_what_it_has_made(name, block):
    """Every name is bound in the block itself: it is no fragment."""
    tree = ast.parse(block)
    names = [n for n in ast.walk(tree) if isinstance(n, ast.Name)]
    bound = {n.id for n in names if isinstance(n.ctx, ast.Store)} | set(dir(builtins))
    bound |= {
        (a.asname or a.name).split(".")[0]
        for n in ast.walk(tree)
        if isinstance(n, ast.Import | ast.ImportFrom)
        for a in n.names
    }
    assert {n.id for n in names} <= bound
