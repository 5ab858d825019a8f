"""The example of docs/python.md, as the page has it but for the size of the picture."""
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import support

SMALL = ("resolution=[40,40]", "reference_spp.test=32")  # of two values for a key the last one counts


class Page(unittest.TestCase):
    def setUp(self):
        held = tempfile.TemporaryDirectory()
        self.addCleanup(held.cleanup)
        self.folder = Path(held.name)
        (self.folder / "data").symlink_to(support.ROOT / "data")
        page = (support.ROOT / "docs/python.md").read_text()
        self.blocks = re.findall(r"^```(\w+)\n(.*?)^```$", page, re.M | re.S)

    def block(self, language, word):
        return next(text for kind, text in self.blocks if kind == language and word in text)

    def test_the_example_runs(self):
        command = self.block("sh", "ld_render").replace("\\\n", " ").split()
        done = subprocess.run([support.PROGRAMS / "ld_render", *command[1:], *SMALL], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        (self.folder / "example.py").write_text(self.block("python", "import"))
        done = subprocess.run([sys.executable, "example.py"], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        scores = {name: float(value) for name, value in re.findall(r"^(noisy|denoised|radiance) +(\S+) +\S+$", done.stdout, re.M)}
        self.assertLess(scores["denoised"], scores["radiance"])
        self.assertLess(scores["radiance"], scores["noisy"])
        self.assertTrue((self.folder / "denoised.exr").exists() and (self.folder / "compared.png").exists())

    def test_it_asks_for_the_packages_that_a_build_finds(self):
        """Every library of the package's configuration is in the page's list."""
        asked = self.block("sh", "apt-get")
        configuration = (support.ROOT / "CMakeLists.txt").read_text()
        needed = {"fmt": "libspdlog-dev", "spdlog": "libspdlog-dev", "yaml-cpp": "libyaml-cpp-dev", "nlohmann_json": "nlohmann-json3-dev",
                  "OpenEXR": "libopenexr-dev", "PNG": "libpng-dev", "Threads": "g++", "OpenMP": "g++"}
        found = re.findall(r"^find_package\((\S+)", configuration, re.M)
        self.assertEqual(sorted(set(found)), sorted(needed))
        for name in found:
            self.assertIn(needed[name], asked)


if __name__ == "__main__":
    unittest.main()
