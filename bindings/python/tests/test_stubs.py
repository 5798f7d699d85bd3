"""The type stub says what the module has."""

import subprocess
import sys

import pytest


def test_stub_is_that_of_the_module(tmp_path):
    pytest.importorskip("mypy")
    (tmp_path / "mypy.ini").write_text("[mypy]\n[mypy-mujoco.*]\nignore_missing_imports = True\n")
    for tool in [["mypy.stubtest", "rtrt", "--ignore-missing-stub", "--mypy-config-file"], ["mypy", "--strict", "-p", "rtrt", "--config-file"]]:
        run = subprocess.run([sys.executable, "-m", *tool, "mypy.ini"], cwd=tmp_path, capture_output=True, text=True)
        assert run.returncode == 0, run.stdout + run.stderr
