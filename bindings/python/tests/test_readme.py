"""The Python code of the README runs, block after block."""

import os
import re
from pathlib import Path

import pytest

README = Path(__file__).parents[1] / "README.md"


def test_code_of_the_readme(tmp_path):
    pytest.importorskip("PIL")
    pytest.importorskip("mujoco")
    blocks = re.findall(r"```python\n(.*?)```", README.read_text(), re.S)
    assert len(blocks) >= 5
    names, before = {}, os.getcwd()
    os.chdir(tmp_path)
    try:
        for number, block in enumerate(blocks):
            exec(compile(block, f"block {number}", "exec"), names)
    finally:
        os.chdir(before)
    assert (tmp_path / "first.png").stat().st_size > 1000
