"""Snippets of programs in the pages: Python that begins with an import is run, C and C++ that include a header are compiled."""
import functools
import re
import subprocess

from header_comments import ROOT

PYTHONS = ["python3", "/usr/bin/python3", str(ROOT / "out/peers/venv/bin/python")]
COMPILERS = {"c": ["cc", "-std=c11", "-Wall", "-Wextra", "-Werror", "-x", "c"],
             "cpp": ["c++", "-std=c++17", "-Wall", "-Wextra", "-Werror", "-x", "c++"]}


@functools.lru_cache(None)
def python_with(modules):
    """A Python that has them all, or None."""
    for python in PYTHONS:
        try:
            if subprocess.run([python, "-c", "import " + ", ".join(modules)], capture_output=True).returncode == 0:
                return python
        except FileNotFoundError:
            pass
    return None


def is_snippet(block):
    return block.language == "python" and re.match(r"import |from ", block.text) is not None or \
        block.language in COMPILERS and "#include" in block.text


def command_of(block, folder, declarations):
    """(the command that tries a snippet, why there is none)."""
    source = folder / f"snippet_{block.line}.{block.language}"
    if block.language == "python":
        modules = tuple(name for name in re.findall(r"^(?:import|from) (\w+)", block.text, re.M)
                        if not (ROOT / "scripts/peers" / f"{name}.py").exists())
        python = python_with(modules)
        source.write_text(block.text)
        missing = [path for path in re.findall(r'read_\w+\("([^"]+)"\)', block.text) if not (folder / path).exists()]
        if missing:
            return "", f"needs {missing[0]}, which a command above makes"
        return (f"{python} {source.name}", "") if python else ("", f"no Python here has all of {', '.join(modules)} (PyPI)")
    includes = "".join(line + "\n" for line in block.text.splitlines() if line.startswith("#include"))
    rest = "".join(line + "\n" for line in block.text.splitlines() if not line.startswith("#include"))
    if not re.search(r"^\w.*\) \{$", rest, re.M):   # no functions: statements of one
        rest = f"{declarations.get(block.language, '')}\nint snippet(void);\nint snippet(void) {{\n{rest}return 0;\n}}\n"
    source.write_text(includes + rest)
    header = re.search(r"#include <(OpenImageDenoise/\S+)>", includes)
    if header:
        found = subprocess.run([*COMPILERS[block.language], "-fsyntax-only", "-"], input=f"#include <{header[1]}>\n", text=True,
                               capture_output=True)
        if found.returncode:
            return "", "no headers of Open Image Denoise here"
    return " ".join([*COMPILERS[block.language], "-fsyntax-only", f"-I{ROOT}/src/embed/include", source.name]), ""
