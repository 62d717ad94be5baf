"""Execute the notebooks from their paired scripts: `python notebooks/build.py`."""

import sys
from pathlib import Path

import jupytext
import nbformat
from nbclient import NotebookClient

FOLDER = Path(__file__).parent


def scripts() -> list[Path]:
    """The paired scripts, in order."""
    return sorted(FOLDER.glob("[0-9]*.py"))


def execute(script: Path, timeout: int = 900) -> nbformat.NotebookNode:
    """Run a script's cells in a fresh kernel and give the notebook with its outputs."""
    notebook = jupytext.read(script)
    notebook.metadata.kernelspec = {
        "display_name": "Python 3",
        "language": "python",
        "name": "python3",
    }
    NotebookClient(notebook, timeout=timeout, resources={"metadata": {"path": FOLDER}}).execute()
    return notebook


def main() -> int:
    """Write every notebook beside its script."""
    for script in scripts():
        notebook = execute(script)
        # Run times would make every rebuild differ from the one before.
        for cell in notebook.cells:
            cell.metadata.pop("execution", None)
        nbformat.write(notebook, script.with_suffix(".ipynb"))
        print(f"wrote {script.with_suffix('.ipynb').name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
