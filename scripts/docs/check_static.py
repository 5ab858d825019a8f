"""What can be said of the pages without running anything: programs, options, keys, paths, links and snippets that are shown exist."""
import functools
import json
import re

import known
import pages
from header_comments import ROOT

LANGUAGES = {"sh", "text", "yaml", "json", "python", "c", "cpp", "cmake"}
OVERRIDES = {"ld_train": "train", "ld_render": "recipe"}
SECTIONS = "network|data|optimizer|run|watch|scenes|scene_file|sequence|reference_spp|frames"
FOLDERS = "src|models|configs|docs|scripts|tests|data|examples|integrations"
WRITTEN = ("data/generated",)   # folders that programs make


class Findings:
    def __init__(self):
        self.faults, self.counts = [], {}

    def count(self, what, number=1):
        self.counts[what] = self.counts.get(what, 0) + number

    def fault(self, piece, text):
        self.faults.append(f"{piece.place()}: {text}")


@functools.lru_cache(None)
def script_options(path):
    """Those of a script, and of the modules beside it that it imports."""
    options = set(known.script_options(path))
    for module in re.findall(r"^(?:import|from) (\w+)", (ROOT / path).read_text(), re.M):
        beside = (ROOT / path).parent / f"{module}.py"
        if beside.exists():
            options |= known.script_options(str(beside.relative_to(ROOT)))
    return options


@functools.lru_cache(None)
def all_options():
    options = set()
    for name in known.program_names():
        for subcommand in ["", *(known.subcommands(name) if name == "ld_bench" else [])]:
            options |= known.program_options(name, subcommand)
    for path in [*(ROOT / "scripts").rglob("*.sh"), *(ROOT / "scripts").rglob("*.py")]:
        options |= known.script_options(str(path.relative_to(ROOT)))
    for path in (ROOT / "integrations").rglob("*.py"):
        options |= known.script_options(str(path.relative_to(ROOT)))
    return options


def check_options(found, piece, program, arguments, options):
    for argument in arguments:
        match = re.match(r"\[?(--[a-z][\w-]*|-[a-z]$)", argument)
        if match:
            found.count("options")
            if match[1] not in options:
                found.fault(piece, f"{program} has no option {match[1]}")


def check_program(found, piece, name, arguments):
    if name not in known.program_names():
        found.fault(piece, f"there is no program {name}")
        return
    subcommand = ""
    if name == "ld_bench" and arguments and not arguments[0].startswith("-"):
        subcommand = arguments[0].rstrip(",")
        if subcommand not in known.subcommands(name):
            found.fault(piece, f"ld_bench has no subcommand {subcommand}")
            return
    check_options(found, piece, name, arguments, known.program_options(name, subcommand))
    named = [argument for before, argument in zip(["", *arguments], arguments) if before == "--filter"]
    filters = {argument.partition("=")[0]: argument.rpartition("=")[2] for argument in named}  # NAME=KIND or KIND
    for before, argument in zip(["", *arguments], arguments):
        key, equals, _ = argument.lstrip("[").partition("=")
        kind = OVERRIDES.get(name) if not before.startswith("--") else "mapping" if before == "--set" else None
        if before == "--set" and key.partition(".")[0] in filters:
            kind, key = filters[key.partition(".")[0]], key.partition(".")[2]
        if kind and equals and re.fullmatch(r"[a-z][\w.]*", key) and key not in ("key", "key.sub"):
            found.count("keys")
            if not known.is_key(kind, key):
                found.fault(piece, f"{name} knows no key {key}")


def check_command(found, piece, command, external):
    """True when it is one of ours or known to be another's."""
    program, arguments = command[0], command[1:]
    if program in known.PYTHONS and arguments and arguments[0].startswith("scripts/"):
        program, arguments = arguments[0], arguments[1:]
    for argument in arguments:   # bash -c 'exec build/bin/ld_train ...'
        inner = re.search(r"(?:exec )?(build/bin/ld_\w+ .*)", argument)
        if inner and " " in argument:
            for nested in pages.words(inner[1]):
                check_command(found, piece, nested, external)
    if re.match(r"(build/bin/)?ld_\w+$", program):
        check_program(found, piece, program.rsplit("/", 1)[-1], arguments)
    elif program.startswith("scripts/"):
        if not (ROOT / program).is_file():
            found.fault(piece, f"there is no {program}")
        else:
            check_options(found, piece, program, arguments, script_options(program))
            for argument in arguments:   # what scripts pass on to ld_train
                key, equals, _ = argument.partition("=")
                if equals and re.fullmatch(rf"(?:{SECTIONS})\.[\w.]+", key) and not known.is_key("train", key):
                    found.fault(piece, f"ld_train knows no key {key}")
    elif program.startswith("build/tests/"):
        if program.rsplit("/", 1)[-1] not in known.test_programs():
            found.fault(piece, f"there is no test {program}")
    elif program.rsplit("/", 1)[-1] not in external and program not in external:
        found.fault(piece, f"'{program}' is neither a program nor a script of the project, nor in scripts/docs/commands.toml")


def yaml_keys(text):
    """The dotted keys of a block."""
    found, stack = [], []
    for line in text.splitlines():
        match = re.match(r"^( *)(?:- )?(\w+):(.*)$", re.sub(r"(^|\s)#.*$", "", line))
        if not match:
            continue
        depth = len(match[1])
        while stack and stack[-1][0] >= depth:
            stack.pop()
        stack.append((depth, match[2]))
        path = ".".join(name for _, name in stack)
        found.append(path)
        if match[3].strip().startswith("{"):
            found += [f"{path}.{name}" for name in re.findall(r"(\w+):", match[3])]
    return found


def check_yaml(found, block):
    names = yaml_keys(block.text)
    found.count("keys", len(names))
    unknown = {kind: [name for name in names if not known.is_key(kind, name)] for kind in ("train", "recipe", "mapping", "camera")}
    best = min(unknown, key=lambda kind: len(unknown[kind]))
    for name in unknown[best]:
        found.fault(block, f"no {best} file knows the key {name}")


def check_block(found, block, external):
    found.count("blocks")
    if block.language not in LANGUAGES:
        found.fault(block, f"a block of '{block.language}'; expected one of {', '.join(sorted(LANGUAGES))}")
    elif block.language == "sh":
        for command in pages.commands(block):
            for simple in pages.words(command.text) if not command.text.startswith("#!") else script_words(command.text):
                check_command(found, command, simple, external)
    elif block.language == "text" and re.search(r"^(build/bin/)?ld_\w+ .*--", block.text, re.M):
        found.fault(block, "a command in a block of text; expected it in one of sh")
    elif block.language == "yaml":
        check_yaml(found, block)
    elif block.language == "json":
        try:
            json.loads(block.text if block.text.startswith("{") else "{" + block.text + "}")
        except ValueError as error:
            found.fault(block, f"no JSON: {error}")
    elif block.language == "python":
        try:
            compile(block.text, block.place(), "exec")
        except SyntaxError as error:
            found.fault(block, f"no Python: {error}")


def script_words(text):
    return [simple for line in text.splitlines() if line and not line.startswith("#") for simple in pages.words(line)
            if simple[0] not in ("MASTER_PORT=29500",)]


def check_code(found, code, external):
    """Code within a sentence: a command, an option, a key or a path."""
    text = code.text.strip()
    if re.match(r"(build/bin/)?ld_(train|render|denoise|eval|export|import|inspect|bench)( |$)", text) or re.match(r"(scripts|build/tests)/\S+ ", text):
        found.count("commands in sentences")
        for simple in pages.words(text):
            check_command(found, code, simple, external)
    elif text.startswith("--"):
        for option in re.findall(r"--[a-z][\w-]*", text):
            found.count("options")
            if option not in all_options() | external:
                found.fault(code, f"no program or script has the option {option}")
    elif re.fullmatch(rf"(?:{SECTIONS})\.[a-z][\w.*]*[=:]?.*", text) and not re.match(r"\w+\.(json|yaml|h|md|exr|log|csv|safetensors)", text):
        found.count("keys")
        name = re.match(r"[\w.]+", text)[0].rstrip(".")
        if not any(known.is_key(kind, name) for kind in ("train", "recipe")):
            found.fault(code, f"no file knows the key {name}")
    elif re.fullmatch(rf"(?:{FOLDERS})/[\w./*-]*", text) and not text.startswith(WRITTEN):
        found.count("paths")
        if not list(ROOT.glob(text.rstrip("/"))):
            found.fault(code, f"there is no {text}")
    elif re.fullmatch(r"[\w/]+\.(?:py|sh|h|cpp|md)", text) and text not in external:
        found.count("paths")
        if not any(path.endswith("/" + text) for path in known.files()):
            found.fault(code, f"no file of the project is called {text}")


def check_link(found, link):
    target, _, anchor = link.text.partition("#")
    if re.match(r"\w+:", target):
        found.count("links to the web, not followed")
        return
    found.count("links")
    path = (ROOT / link.page).parent / target if target else ROOT / link.page
    if not path.exists():
        found.fault(link, f"a link to {target}, which is not there")
    elif anchor and path.suffix == ".md" and anchor not in pages.anchors(str(path.resolve().relative_to(ROOT))):
        found.fault(link, f"a link to {link.text}, but that page has no such heading")


def same_value(shown, default):
    shown, default = shown.strip("` "), default.strip('"')
    try:
        return float(shown) == float(default)
    except ValueError:
        return shown == default


def check_defaults(found, page, prose):
    """Tables with the heading `| key | value | what |`: the values are the defaults of a training configuration."""
    for table in re.finditer(r"^\| key \| value \| what \|\n\|[-| ]+\|\n((?:\|.*\n)*)", prose, re.M):
        for number, row in enumerate(table[1].splitlines()):
            cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", row)[1:-1]]
            names = re.findall(r"`([^`]+)`", cells[0])
            section = names[0].rpartition(".")[0]
            names = [names[0], *(f"{section}.{name}" for name in names[1:])]
            values = cells[1].split(", ") if len(names) > 1 else [cells[1]]
            for name, value in zip(names, values):
                if name in known.defaults("train"):
                    found.count("defaults")
                    if not same_value(value, known.defaults("train")[name]):
                        line = prose.count("\n", 0, table.start()) + 3 + number
                        found.fault(pages.Piece(page, line, row), f"{name} is {value} here, but {known.defaults('train')[name]} in the program")


def check_page(found, page, external):
    blocks, codes, links, prose = pages.read_page(page)
    check_defaults(found, page, prose)
    for block in blocks:
        check_block(found, block, external)
    for code in codes:
        check_code(found, code, external)
    for link in links:
        check_link(found, link)
