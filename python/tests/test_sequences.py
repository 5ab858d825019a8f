"""Filters and what is remembered from frame to frame."""
import shutil
import tempfile
import unittest
from pathlib import Path

import numpy as np

import layered_denoiser as ld
import support


class Sequences(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.held = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.held.cleanup)
        cls.folder = Path(cls.held.name)
        recipe = support.ROOT / "data/recipes/sequence_quick.yaml"
        small = ("resolution=[32,18]", "reference_spp.train=2", "reference_spp.test=2")
        support.run("ld_render", "--recipe", recipe, "--frames", "0:4", "--out", cls.folder / "data", *small)
        cls.frames = []
        for number in range(4):
            shutil.copy(cls.folder / f"data/frame_{number:06}.exr", cls.folder / f"shot.{number}.exr")
            cls.frames.append(ld.read_frame(cls.folder / f"shot.{number}.exr"))

    def of_program(self, *options):
        out = self.folder / "out"
        shutil.rmtree(out, ignore_errors=True)
        out.mkdir()
        support.run("ld_denoise", *options, self.folder / "shot.#.exr", "--output", out / "shot.#.exr", "--float", "--threads", 1)
        return [ld.read_image(out / f"shot.{number}.exr") for number in range(4)]

    def test_frames_have_their_matrices(self):
        for frame in self.frames:
            self.assertEqual(frame.world_to_camera.shape, (4, 4))
            self.assertEqual(frame.world_to_ndc.shape, (4, 4))
        self.assertIsNone(ld.read_frame(support.FRAME).world_to_camera)

    def test_filters_give_the_pictures_of_the_program(self):
        for kind, settings, options in (
            ("svgf", {}, ()),
            ("svgf", {"alpha": 0.1, "split": False}, ("--set", "svgf.alpha=0.1", "--set", "svgf.split=false")),
            ("eaw", {"levels": 3}, ("--set", "eaw.levels=3")),
        ):
            denoiser = ld.Denoiser.filter(kind, **settings)
            self.assertEqual((denoiser.network, denoiser.weights, denoiser.remembers), (kind, "", kind == "svgf"))
            for frame, expected in zip(self.frames, self.of_program("--filter", kind, *options)):
                np.testing.assert_array_equal(denoiser.denoise(frame, threads=1), expected)

    def test_a_restart_forgets(self):
        denoiser = ld.Denoiser.filter("svgf")
        first = denoiser.denoise(self.frames[0])
        self.assertFalse(np.array_equal(denoiser.denoise(self.frames[0]), first))
        denoiser.restart()
        np.testing.assert_array_equal(denoiser.denoise(self.frames[0]), first)

    def test_weights_that_remember_nothing_say_so(self):
        denoiser = ld.Denoiser("common_fast")
        self.assertFalse(denoiser.remembers)
        first = denoiser.denoise(self.frames[0])
        np.testing.assert_array_equal(denoiser.denoise(self.frames[0]), first)

    def test_what_does_not_fit_is_refused(self):
        with self.assertRaisesRegex(ValueError, "expected eaw or svgf"):
            ld.Denoiser.filter("bilateral")
        with self.assertRaisesRegex(ValueError, "sigma"):
            ld.Denoiser.filter("eaw", sigma=1)
        denoiser = ld.Denoiser.filter("eaw")
        with self.assertRaisesRegex(ValueError, "parts of the light"):
            denoiser.denoise_parts(self.frames[0], {"all": self.frames[0].samples["radiance"]})
        with self.assertRaisesRegex(ValueError, "a memory budget goes with models"):
            denoiser.denoise(self.frames[0], max_memory_mb=1000)
        with self.assertRaisesRegex(ValueError, "4 x 4 finite"):
            denoiser.denoise(self.frames[0], world_to_camera=np.eye(3))
