"""What the comments of the configuration structs say about their fields: the structs are those of src/core/config_visitor.h,
plain members with a comment above or behind each, and a `visit` that names their keys."""
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HEADERS = ["src/training/run/config.h", "src/losses/clip_loss_config.h", "models/network_config.h", "src/render/recipe/recipe.h",
           "src/render/file/scene_file_config.h", "src/render/recipe/sequence_config.h", "src/render/random/random_scene.h",
           "src/import/mapping.h", "src/import/view_camera.cpp", "src/filters/settings.h"]


class Struct:
    def __init__(self):
        self.members = {}   # name: (type, comment)
        self.keys = {}      # key: name of the member
        self.inlined = []   # members whose keys are this struct's own


def bodies(text):
    """(name, body) of each struct that has a visit()."""
    for match in re.finditer(r"^struct (\w+) \{\n(.*?)^\};", text, re.M | re.S):
        if "visit(Visitor& v)" in match[2]:
            yield match[1], match[2]


def declared(statement):
    """(type, names) of `std::vector<double> a = {1}, b = {2}`."""
    plain = re.sub(r"\{[^{}]*\}", "", re.sub(r"\{[^{}]*\}", "", statement))
    match = re.match(r"(?:std::vector<)?([\w:<>]+?)>*\s+(.*)$", plain.strip(), re.S)
    names = [part.split("=")[0].strip() for part in match[2].split(",")]
    return match[1], names


def read_members(lines):
    members, above, statement, behind, last = {}, [], "", [], None
    for line in lines:
        code, _, comment = line.partition("//")
        comment = comment.lstrip("/").strip()
        if not code.strip():
            if not comment:
                above, last = [], None
            elif last is not None and len(code) > 4:  # a comment behind a member goes on
                last.append(comment)
            else:
                above.append(comment)
                last = None
            continue
        statement += code
        if comment:
            behind.append(comment)
        last = None
        if not code.rstrip().endswith(";"):
            continue
        if "(" not in statement.split("=")[0]:  # no method
            kind, names = declared(statement.strip().rstrip(";"))
            text = [*above, *behind]
            for name in names:
                members[name] = (kind, text)
            last = text if behind else None
        above, statement, behind = [], "", []
    return members


def read_structs():
    structs = {}
    for header in HEADERS:
        for name, body in bodies((ROOT / header).read_text()):
            struct = structs.setdefault(name, Struct())
            data, _, visit = body.partition("template <class Visitor>")
            struct.members = {member: (kind, " ".join(text)) for member, (kind, text) in read_members(data.splitlines()).items()}
            for match in re.finditer(r'v\.\w+\(\s*"(\w+)",\s*(\w+)', visit):
                struct.keys[match[1]] = match[2]
            struct.inlined = re.findall(r"(\w+)\.visit\(v\)", visit)
    for struct in structs.values():
        for member in struct.inlined:
            held = structs[struct.members[member][0]]
            struct.members = {**held.members, **struct.members}
            struct.keys = {**held.keys, **struct.keys}
    return structs


def describe(structs, struct, path):
    """The comment of a key such as optimizer.one_cycle.rise; that of its section where it has none itself."""
    text = ""
    for word in path.replace("[]", "").split("."):
        kind, comment = structs[struct].members[structs[struct].keys[word]]
        text = comment or text
        struct = kind
    return text
