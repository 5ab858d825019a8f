"""Wrong calls say what is wrong, what was expected and what was found."""
import tempfile
import unittest
from pathlib import Path

import numpy as np

import layered_denoiser as ld
import support


class WrongSamples(unittest.TestCase):
    def setUp(self):
        self.denoiser = ld.Denoiser("common_fast")
        self.samples = support.noisy_samples(5, 7, 2)

    def refused(self, *words, denoiser=None, valid=None, without=(), error=ValueError, options=None, **changed):
        samples = {name: array for name, array in {**self.samples, **changed}.items() if name not in without}
        with self.assertRaises(error) as caught:
            (denoiser or self.denoiser).denoise(samples, valid, **(options or {}))
        for word in words:
            self.assertIn(word, str(caught.exception))

    def test_features(self):
        self.refused("unknown feature 'albdo'", "did you mean 'albedo'", albdo=self.samples["albedo"])
        self.refused("'radiance' is missing", "found normal, depth", "render it", without=["radiance"])
        needs_all = ld.Denoiser(support.SAMPLE_WEIGHTS)
        self.refused("'roughness' is missing", "expected radiance, normal", "found radiance", denoiser=needs_all)
        with self.assertRaisesRegex(ValueError, "samples are a ndarray; expected a dict"):
            self.denoiser.denoise(self.samples["radiance"])
        with self.assertRaisesRegex(ValueError, "key 3"):
            self.denoiser.denoise({**self.samples, 3: 4})
        with self.assertRaisesRegex(ValueError, "'radiance' is missing.*found nothing"):
            self.denoiser.denoise({})

    def test_shapes(self):
        radiance, albedo, depth = (self.samples[name] for name in ("radiance", "albedo", "depth"))
        self.refused("'radiance' has the shape [5, 7, 3]", "expected [samples, height, width, 3]", "array[None]", radiance=radiance[0])
        self.refused("[2, 3, 5, 7]", "numpy.moveaxis(array, 1, -1)", radiance=np.moveaxis(radiance, -1, 1))
        self.refused("'radiance' has the shape [2, 5, 7, 4]", radiance=np.concatenate([radiance, depth], -1))
        self.refused("'albedo' has the shape [2, 5, 6, 3]", "expected [2, 5, 7, 3]", "size of the radiance", albedo=albedo[:, :, 1:])
        self.refused("'albedo' has the shape [1, 5, 7, 3]", "expected [2, 5, 7, 3]", albedo=albedo[:1])
        self.refused("'depth' has the shape [5, 7]", "expected [2, 5, 7, 1]", depth=depth[0, :, :, 0])
        self.refused("[0, 5, 7, 3]", radiance=radiance[:0])
        self.refused("[2, 5, 0, 3]", radiance=radiance[:, :, :0])
        self.refused("has the shape []", radiance=1.0)

    def test_types(self):
        self.refused("'radiance' has the dtype complex64", "expected float32", radiance=self.samples["radiance"].astype(np.complex64))
        self.refused("'albedo' has the dtype", "expected float32", albedo="red")
        self.refused("'albedo' is no array", albedo=[[1, 2], [3]])
        self.refused("'albedo' has the dtype object", albedo=None)

    def test_valid(self):
        valid = np.ones((2, 5, 7), bool)
        self.refused("valid has the shape [2, 5]", "expected [2, 5, 7]", valid=valid[:, :, 0])
        self.refused("valid has the dtype float64", "expected bool", valid=valid.astype(float))
        self.refused("nothing to see", "not valid", valid=~valid)
        self.refused("nothing to see", "NaN", radiance=np.full((2, 5, 7, 3), np.nan))

    def test_options(self):
        for name, value in {"threads": -1, "max_memory_mb": 1.5, "skip_within": -1, "depth_scale": 0, "progress": 3}.items():
            self.refused(f"{name} is {value}", "expected", options={name: value})
        self.refused("threads is True", options={"threads": True})
        self.refused("skip_within is nan", options={"skip_within": float("nan")})
        self.refused("skip_within is '0'", options={"skip_within": "0"})
        self.refused("depth_scale is nan", options={"depth_scale": float("nan")})
        self.refused("memory budget", "the smallest is", options={"max_memory_mb": 1})
        with self.assertRaises(TypeError):
            self.denoiser.denoise(self.samples, None, 1.0)

    def test_a_wrong_call_leaves_the_denoiser_in_order(self):
        expected = self.denoiser.denoise(self.samples)
        self.refused("memory budget", options={"max_memory_mb": 1})
        self.refused("nothing to see", radiance=np.full((2, 5, 7, 3), np.nan))
        np.testing.assert_array_equal(self.denoiser.denoise(self.samples), expected)


class WrongFiles(unittest.TestCase):
    def setUp(self):
        held = tempfile.TemporaryDirectory()
        self.addCleanup(held.cleanup)
        self.folder = Path(held.name)
        self.text = self.folder / "text.exr"
        self.text.write_text("no picture, no weights")

    def test_weights(self):
        for name in ("comon", "/nowhere/weights.safetensors", ""):
            with self.assertRaisesRegex(RuntimeError, f"no such model: {name}; .*common_fast, common_fine, common_small, common_tiny, history_fast, means"):
                ld.Denoiser(name)
        with self.assertRaisesRegex(RuntimeError, "text.exr"):
            ld.Denoiser(self.text)
        with self.assertRaisesRegex(RuntimeError, "no weights in this folder"):
            ld.Denoiser(self.folder)
        with self.assertRaisesRegex(ValueError, "as text"):
            ld.Denoiser(b"common")

    def test_frames_and_images(self):
        for read in (ld.read_frame, ld.read_image):
            with self.assertRaisesRegex(RuntimeError, "nowhere.exr"):
                read(self.folder / "nowhere.exr")
            with self.assertRaisesRegex(RuntimeError, "text.exr"):
                read(self.text)
        with self.assertRaisesRegex(RuntimeError, "4 samples a pixel, but 9 are asked for"):
            ld.read_frame(support.FRAME, samples=9)
        with self.assertRaisesRegex(ValueError, "samples is -1"):
            ld.read_frame(support.FRAME, samples=-1)

    def test_images_to_write(self):
        for shape in ((3,), (2, 2, 2), (2, 2, 5), (0, 2, 3), (2, 2, 2, 3)):
            with self.assertRaisesRegex(ValueError, "expected \\[height, width, channels\\]"):
                ld.write_image(self.folder / "a.exr", np.zeros(shape))
        with self.assertRaisesRegex(ValueError, "1, 3 or, in EXR, 4"):
            ld.write_image(self.folder / "a.png", np.zeros((2, 2, 4)))
        with self.assertRaisesRegex(ValueError, "unknown extension '.jpg'; expected .exr"):
            ld.write_image(self.folder / "a.jpg", np.zeros((2, 2, 3)))
        with self.assertRaisesRegex(RuntimeError, "text.exr"):  # which is no folder
            ld.write_image(self.text / "a.exr", np.zeros((2, 2, 3)))
        self.assertEqual(list(self.folder.iterdir()), [self.text])


class Files(unittest.TestCase):
    def setUp(self):
        held = tempfile.TemporaryDirectory()
        self.addCleanup(held.cleanup)
        self.folder = Path(held.name)

    def test_images_come_back(self):
        image = np.arange(2 * 3 * 3, dtype=np.float64).reshape(2, 3, 3)[:, ::-1]
        ld.write_image(self.folder / "a.exr", image)
        read = ld.read_image(str(self.folder / "a.exr"))
        self.assertEqual(read.dtype, np.float32)
        np.testing.assert_array_equal(read, image)

    def test_png_holds_what_is_not_finite_as_black(self):
        image = np.float32([[[0, 0, 0], [np.nan, np.inf, -1]]])
        ld.write_image(self.folder / "a.png", image)
        ld.write_image(self.folder / "b.png", np.zeros_like(image))
        self.assertEqual((self.folder / "a.png").read_bytes(), (self.folder / "b.png").read_bytes())
        for shape in ((4, 5), (4, 5, 1)):
            ld.write_image(self.folder / "grey.PNG", np.ones(shape, np.float16))

    def test_frames_hold_what_was_rendered(self):
        frame = ld.read_frame(support.FRAME)
        self.assertEqual(frame.samples["radiance"].shape, (4, 28, 40, 3))
        self.assertEqual(frame.valid.shape, (4, 28, 40))
        self.assertEqual(frame.valid.dtype, bool)
        radiance = frame.samples["radiance"]
        del frame  # arrays keep the memory that they look into
        mean = radiance.mean(axis=0)
        np.testing.assert_allclose(mean, ld.read_image(support.FRAME), rtol=2e-3, atol=1e-6)  # which is half floats


if __name__ == "__main__":
    unittest.main()
