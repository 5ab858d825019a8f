"""Parts of the light sum to the picture, whose bits they leave."""
import unittest

import numpy as np

import layered_denoiser as ld
import support


class Parts(unittest.TestCase):
    def setUp(self):
        self.samples = support.noisy_samples()
        radiance = self.samples["radiance"]
        share = np.random.default_rng(7).uniform(0, 1.2, radiance.shape).astype(np.float32)
        self.parts = {"key": radiance * share, "rest": radiance - radiance * share}

    def test_sum_to_the_picture(self):
        for weights in ("common", "common_fast", "means"):
            denoiser = ld.Denoiser(weights)
            expected = denoiser.denoise(self.samples, threads=1)
            alpha = np.ones(self.samples["radiance"].shape[:3])
            denoised = denoiser.denoise_parts(self.samples, self.parts, alpha, threads=1)
            np.testing.assert_array_equal(denoised.picture, expected)
            self.assertEqual(list(denoised.parts), ["key", "rest"])
            total = denoised.parts["key"] + denoised.parts["rest"]
            self.assertLessEqual(abs(total - expected).max(), 1e-5 * expected.max())
            np.testing.assert_allclose(denoised.alpha, 1, atol=1e-6)

    def test_any_strides_and_none(self):
        denoiser = ld.Denoiser("common_fast")
        planar = {name: np.moveaxis(np.ascontiguousarray(np.moveaxis(part, -1, 1)), 1, -1) for name, part in self.parts.items()}
        first, second = (denoiser.denoise_parts(self.samples, parts, threads=1) for parts in (self.parts, planar))
        np.testing.assert_array_equal(first.parts["key"], second.parts["key"])
        self.assertIsNone(first.alpha)
        self.assertEqual(denoiser.denoise_parts(self.samples).parts, {})

    def test_wrong_ones(self):
        denoiser = ld.Denoiser("common_fast")
        with self.assertRaisesRegex(ValueError, r"part 'key' has the shape \[4, 12, 17, 2\]; expected \[4, 12, 17, 3\]"):
            denoiser.denoise_parts(self.samples, {"key": self.parts["key"][..., :2]})
        with self.assertRaisesRegex(ValueError, "parts are a list"):
            denoiser.denoise_parts(self.samples, [self.parts["key"]])
        with self.assertRaisesRegex(ValueError, r"alpha has the shape \[12, 17\]"):
            denoiser.denoise_parts(self.samples, {}, np.ones((12, 17)))
        with self.assertRaisesRegex(RuntimeError, "no part of the light is called 'lamp'; there is none"):
            ld.read_frame(support.FRAME, also=["lamp"])
        with self.assertRaisesRegex(ValueError, "also is 'lamp'; expected a list"):
            ld.read_frame(support.FRAME, also="lamp")


if __name__ == "__main__":
    unittest.main()
