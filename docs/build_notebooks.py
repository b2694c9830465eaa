"""Run the notebooks in examples/ and write them with what they show as pages in docs/notebooks/.

Run by hand after a change of a notebook, some minutes: ``python docs/build_notebooks.py``.
"""

import base64
import tempfile
from pathlib import Path

import nbclient
import nbformat

HERE = Path(__file__).parent
PAGES, EXAMPLES = HERE / "notebooks", HERE.parent / "examples"
NOTEBOOKS = ("throw_and_law", "study_to_equation", "engine_to_verdict")


def page_of(notebook: nbformat.NotebookNode, name: str) -> str:
    """Return the page of a notebook that has run, and write its pictures beside it."""
    parts, pictures = [], 0
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            parts.append(cell.source)
            continue
        parts.append(f"```py\n{cell.source}\n```")  # tests run the notebook, not its page
        for output in cell.outputs:
            picture = output.get("data", {}).get("image/png")
            if picture:
                pictures += 1
                path = PAGES / f"{name}-{pictures}.png"
                path.write_bytes(base64.b64decode(picture))
                parts.append(f"![What the lines above draw]({path.name})")
            elif output.get("name") == "stdout":
                parts.append(f"```text\n{output.text.rstrip()}\n```")
    return "\n\n".join([*parts, f"The notebook is `examples/{name}.ipynb`."]) + "\n"


def main() -> None:
    """Write the page of each notebook."""
    for name in NOTEBOOKS:
        notebook = nbformat.read(EXAMPLES / f"{name}.ipynb", as_version=4)
        with tempfile.TemporaryDirectory() as folder:
            nbclient.NotebookClient(
                notebook, timeout=600, resources={"metadata": {"path": folder}}
            ).execute()
        (PAGES / f"{name}.md").write_text(page_of(notebook, name), encoding="utf-8")


if __name__ == "__main__":
    main()
