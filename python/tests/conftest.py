"""What the tests share: the program, and scenes that were run once."""

import os
import signal
import subprocess
from pathlib import Path

import pytest
import tumblenet


@pytest.fixture(scope="session")
def root() -> Path:
    """The folder of the project."""
    return Path(__file__).parents[2]


@pytest.fixture(scope="session")
def program(root):
    """Runs the program that `TUMBLENET_PROGRAM` names."""
    path = os.environ.get("TUMBLENET_PROGRAM", root / "target/release/tumblenet")

    def run(*arguments):
        done = subprocess.run([path, *map(str, arguments)], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


@pytest.fixture
def interruptible():
    """Has an interrupt raise, also where Python was started with it ignored, as what runs in the background is."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(scope="session")
def capture():
    """Past the first contact of a tumbling Cubesat, with threads."""
    scene = tumblenet.Scene("cubesat-spin-x-2.0-tube", duration_s=1.5)
    return scene, tumblenet.run(scene)
