"""Reads the pages: fenced blocks, code within sentences, links and headings; takes shell text apart into commands."""
import re
import shlex
from dataclasses import dataclass
from pathlib import Path

from header_comments import ROOT


@dataclass
class Piece:
    page: str   # "docs/training.md"
    line: int
    text: str
    language: str = ""   # of a fenced block

    def place(self):
        return f"{self.page}:{self.line}"


def page_names():
    return ["README.md"] + sorted(str(path.relative_to(ROOT)) for path in (ROOT / "docs").glob("*.md"))


def read_page(name):
    """(blocks, code in sentences, links, text without blocks)."""
    text = (ROOT / name).read_text()
    line_of = lambda at: text.count("\n", 0, at) + 1
    blocks = [Piece(name, line_of(match.start()), match[2], match[1])
              for match in re.finditer(r"^```([^\n]*)\n(.*?)^```$", text, re.M | re.S)]
    # Blanks in place of blocks, so that lines keep their numbers.
    prose = re.sub(r"^```[^\n]*\n.*?^```$", lambda match: re.sub(r"[^\n]", " ", match[0]), text, flags=re.M | re.S)
    prose = re.sub(r"^ {4}[^\n]*$", lambda match: " " * len(match[0]), prose, flags=re.M)
    codes = [Piece(name, line_of(match.start()), re.sub(r"\\\|[^ |]+", "", match[1].replace("\n", " ")))
             for match in re.finditer(r"`([^`]+)`", prose)]
    without_code = re.sub(r"`[^`]+`", lambda match: re.sub(r"[^\n]", " ", match[0]), prose)
    links = [Piece(name, line_of(match.start()), match[1]) for match in re.finditer(r"\]\(([^)\s]+)\)", without_code)]
    return blocks, codes, links, prose


def anchors(name):
    """What GitHub calls the headings of a page."""
    headings = re.findall(r"^#+ (.*)$", read_page(name)[3], re.M)
    plain = [re.sub(r"[^\w\- ]", "", re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()) for heading in headings]
    return {heading.strip().replace(" ", "-") for heading in plain}


def commands(block):
    """The lines of a shell block as one Piece a command; a script with #! is one command as a whole."""
    if block.text.startswith("#!"):
        return [Piece(block.page, block.line + 1, block.text)]
    found, text, start = [], "", None
    for number, line in enumerate(block.text.splitlines()):
        start = number if not text else start
        text += line
        if line.endswith("\\"):
            text = text[:-1]
            continue
        text = re.sub(r"(^|\s)#(?!#).*$", "", text)  # `shot.####.exr` is no comment
        if text.strip():
            found.append(Piece(block.page, block.line + 1 + start, re.sub(r"\s+", " ", text.strip())))
        text = ""
    return found


def words(text):
    """The simple commands of a line of shell, each a list of words, without assignments before the program."""
    try:
        lexer = shlex.shlex(text, posix=True, punctuation_chars="();&|<>")
        lexer.whitespace_split = True
        lexer.commenters = ""
        tokens = list(lexer)
    except ValueError:
        return []
    simple, current = [], []
    for token in [*tokens, ";"]:
        if re.fullmatch(r"[();&|<>]+", token):
            if current:
                simple.append(current)
            current = []
        else:
            current.append(token)
    result = []
    for command in simple:
        while command and (re.match(r"[A-Z_]+=", command[0]) or command[0] in ("time", "nice", "export")):
            command = command[1:]
        if command:
            result.append(command)
    return result
