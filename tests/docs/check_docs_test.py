"""The check of the pages finds what it is there to find: faults that are made up here, and no others."""
import sys
import tomllib
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts/docs"))

import check_static
import header_comments
import known
import pages
import run_commands
import snippets

with open(ROOT / "scripts/docs/commands.toml", "rb") as file:
    RULES = tomllib.load(file)
EXTERNAL = set(RULES["external"])


def faults_of(check, text, language=""):
    found = check_static.Findings()
    check(found, pages.Piece("docs/made_up.md", 1, text, language), *([EXTERNAL] if check is not check_static.check_link else []))
    return found.faults


class BlocksTest(unittest.TestCase):
    def faults(self, text, language="sh"):
        return faults_of(check_static.check_block, text, language)

    def test_right_commands(self):
        for text in ["build/bin/ld_train --config a.yaml optimizer.ema=0.9 --out b  # fine", "ld_bench loader --data d --epochs 3",
                     "ld_denoise --set depth.kind=planar 'shot.####.exr' --output o", "time ld_render --recipe r spp=1 --preview p.png",
                     "A=1 scripts/tradeoff.sh a b && cmp a b", "srun bash -c 'exec build/bin/ld_train --config t.yaml --out r'"]:
            self.assertEqual(self.faults(text), [], text)

    def test_wrong_commands(self):
        for text, says in [("ld_train --confg a.yaml", "no option --confg"), ("ld_train --config a optimizer.emma=1", "no key optimizer.emma"),
                           ("ld_render --recipe a optimizer.ema=1", "no key optimizer.ema"), ("ld_trian --config a", "no program ld_trian"),
                           ("ld_bench speed", "no subcommand speed"), ("ld_bench ops --data d", "no option --data"),
                           ("scripts/nothing.sh", "no scripts/nothing.sh"), ("scripts/check_docs.sh && wget x", "'wget'"),
                           ("ld_denoise --set depth.kid=planar a", "no key depth.kid"), ("build/tests/test_nothing", "no test"),
                           ("srun bash -c 'exec build/bin/ld_train --out r --frames 1'", "no option --frames")]:
            faults = self.faults(text)
            self.assertTrue(len(faults) == 1 and says in faults[0], (text, faults))

    def test_other_languages(self):
        self.assertEqual(self.faults("network:\n  layers: 3   # a comment\nloss: l1\n", "yaml"), [])
        self.assertIn("optimizer.rate", self.faults("optimizer:\n  rate: 3\nloss: l1\n", "yaml")[0])
        self.assertEqual(self.faults("frames: {train: 1, test: 2}\nspp: 2\n", "yaml"), [])
        self.assertIn("frames.tran", self.faults("frames: {tran: 1, test: 2}\nspp: 2\n", "yaml")[0])
        self.assertIn("no JSON", self.faults('{"a": 1', "json")[0])
        self.assertIn("no Python", self.faults("def f(:\n", "python")[0])
        self.assertIn("expected one of", self.faults("x", "")[0])
        self.assertIn("in a block of text", self.faults("ld_train --config a", "text")[0])


class SentencesTest(unittest.TestCase):
    def test_code(self):
        for text in ["--max-memory", "optimizer.ema", "run.json", "src/core/error.h", "ld_export --model RUN --format safetensors",
                     "data/generated/small", "data.*", "network.features=auto", "oiiotool a b"]:
            self.assertEqual(faults_of(check_static.check_code, text), [], text)
        for text in ["--max-memry", "optimizer.emma", "src/core/eror.h", "ld_export --modl RUN", "no_such_file.py", "docs/*.rst"]:
            self.assertEqual(len(faults_of(check_static.check_code, text)), 1, text)

    def test_defaults(self):
        table = "| key | value | what |\n| --- | --- | --- |\n| `loss` | `smape` | a |\n| `optimizer.beta1`, `beta2` | 0.9, {} | b |\n| `data.*` | | c |\n"
        for value, faults in [("0.999", 0), ("0.99", 1)]:
            found = check_static.Findings()
            check_static.check_defaults(found, "docs/made_up.md", table.format(value))
            self.assertEqual((len(found.faults), found.counts["defaults"]), (faults, 3), found.faults)

    def test_links(self):
        for text in ["training.md#losses", "../README.md", "images/tradeoff.svg", "https://example.org/x", "#nothing_of_a_page_that_is_not"]:
            expected = 1 if text.startswith("#") else 0
            found = check_static.Findings()
            check_static.check_link(found, pages.Piece("docs/export.md", 1, text))
            self.assertEqual(len(found.faults), expected, text)
        for text in ["trainng.md", "training.md#lossess"]:
            self.assertEqual(len(faults_of(check_static.check_link, text)), 1, text)


class CommandsTest(unittest.TestCase):
    def test_lines_become_commands(self):
        block = pages.Piece("p", 1, "a 'x.####.exr' \\\n  b   # why\n\n# only a comment\nc && d\n", "sh")
        self.assertEqual([(piece.line, piece.text) for piece in pages.commands(block)], [(2, "a 'x.####.exr' b"), (6, "c && d")])

    def test_small(self):
        runner = run_commands.Runner(RULES, ROOT, "")
        text = runner.small("build/bin/ld_render --recipe r.yaml --out o spp=8")
        self.assertTrue(text.startswith("build/bin/ld_render --recipe r.yaml --out o spp=8 ") and "resolution=[16,16] spp=8" in text, text)

    def test_what_is_left_out_says_why(self):
        runner = run_commands.Runner(RULES, ROOT, "")
        self.assertIn("builds", runner.left_out(pages.Piece("README.md", 1, "scripts/quickstart.sh")))
        self.assertEqual(runner.left_out(pages.Piece("README.md", 1, "ld_eval --formulas")), "")

    def test_every_rule_is_needed(self):
        shown = [(block.page, command.text) for name in pages.page_names() for block in pages.read_page(name)[0] if block.language == "sh"
                 for command in pages.commands(block)]
        for entry in RULES["left_out"]:
            self.assertTrue(any(check_static.re.search(entry["command"], text) for _, text in shown), f"no page has {entry['command']}")
        for page in [*RULES["page"], *RULES["brief"]["pages"], *RULES["declarations"]]:
            self.assertTrue((ROOT / page).exists(), page)

    def test_snippets(self):
        for language, text, expected in [("python", "import os\n", True), ("python", "x = 1\n", False), ("c", "#include <a.h>\n", True),
                                         ("c", "int x;\n", False), ("sh", "import os\n", False)]:
            self.assertEqual(bool(snippets.is_snippet(pages.Piece("p", 1, text, language))), expected, text)


class KeysTest(unittest.TestCase):
    def test_every_key_has_a_comment(self):
        structs = header_comments.read_structs()
        self.assertEqual(header_comments.describe(structs, "TrainConfig", "optimizer.ema")[:25], "decay of the averaged wei")
        for key in known.keys("train"):
            self.assertTrue(header_comments.describe(structs, "TrainConfig", key), key)

    def test_sections_are_keys(self):
        self.assertTrue(known.is_key("train", "optimizer.one_cycle"))
        self.assertTrue(known.is_key("train", "data.paths.weight"))
        self.assertFalse(known.is_key("train", "optimizer.one"))


if __name__ == "__main__":
    unittest.main()
