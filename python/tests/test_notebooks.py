"""Notebooks run from their first cell to the last, and show what they say they show."""

from pathlib import Path

import pytest

jupytext = pytest.importorskip("jupytext")
nbclient = pytest.importorskip("nbclient")

NOTEBOOKS = sorted((Path(__file__).parents[1] / "notebooks").glob("*.py"))


@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_a_notebook_runs_and_shows_a_replay_and_a_plot(file, tmp_path):
    notebook = jupytext.read(file)
    nbclient.NotebookClient(notebook, kernel_name="python3", timeout=300, resources={"metadata": {"path": tmp_path}}).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    shown = [output["data"] for output in outputs if "data" in output]
    pages = [data["text/html"] for data in shown if "text/html" in data]
    assert any(page.startswith('<iframe srcdoc="<!doctype html>') for page in pages)
    assert any("image/png" in data for data in shown)
    errors = [output["text"] for output in outputs if output.get("name") == "stderr"]
    assert not errors


def test_all_notebooks_are_found():
    assert [file.stem for file in NOTEBOOKS] == ["closing_control", "first_capture", "own_satellite_and_map"]
