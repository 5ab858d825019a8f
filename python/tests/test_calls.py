"""What happens while a picture is computed: progress, cancelling, signals, other threads."""
import os
import signal
import threading
import time
import unittest

import numpy as np

import layered_denoiser as ld
import support


class Alarm(Exception):
    pass


class Progress(unittest.TestCase):
    def setUp(self):
        self.denoiser = ld.Denoiser("common_fast")
        self.samples = support.noisy_samples(64, 64, 2)
        self.expected = self.denoiser.denoise(self.samples, threads=1)

    def tearDown(self):
        np.testing.assert_array_equal(self.denoiser.denoise(self.samples, threads=1), self.expected)

    def test_rises_to_one(self):
        shares = []
        picture = self.denoiser.denoise(self.samples, threads=1, progress=shares.append)
        self.assertGreater(len(shares), 5)
        self.assertEqual(shares, sorted(shares))
        self.assertEqual(shares[-1], 1)
        np.testing.assert_array_equal(picture, self.expected)

    def test_something_false_cancels(self):
        for answer in (False, np.False_, 0):
            shares = []
            with self.assertRaisesRegex(ld.Cancelled, "cancelled"):
                self.denoiser.denoise(self.samples, progress=lambda share: shares.append(share) or answer)
            self.assertLess(shares[-1], 1)
        self.assertTrue(issubclass(ld.Cancelled, RuntimeError))

    def test_what_it_raises_comes_out(self):
        def fail(share):
            raise KeyError(share)

        with self.assertRaises(KeyError):
            self.denoiser.denoise(self.samples, progress=fail)
        with self.assertRaisesRegex(ValueError, "ambiguous"):  # what numpy says of an array as an answer
            self.denoiser.denoise(self.samples, progress=lambda share: np.zeros(2))

    def test_may_not_call_its_own_denoiser(self):
        with self.assertRaisesRegex(RuntimeError, "at work already"):
            self.denoiser.denoise(self.samples, progress=lambda share: self.denoiser.denoise(self.samples) is None)

    def test_may_call_another_one(self):
        other = ld.Denoiser("common_fast")
        self.denoiser.denoise(self.samples, threads=1, progress=lambda share: other.denoise(self.samples, threads=1) is not None)

    def test_sees_the_callers_floating_point_settings(self):
        """The denormals that are flushed while networks compute are there for the progress function."""
        tiny = np.float32(1e-40)
        found = []
        self.denoiser.denoise(self.samples, progress=lambda share: found.append(float(tiny * np.float32(1))))
        self.assertTrue(all(value > 0 for value in found))
        self.assertGreater(tiny * np.float32(1), 0)


class Signals(unittest.TestCase):
    def setUp(self):
        self.samples = support.noisy_samples(256, 256, 4)
        self.denoiser = ld.Denoiser()

    def test_ctrl_c_ends_the_call(self):
        timer = threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT))
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            while True:
                self.denoiser.denoise(self.samples)
        timer.join()

    def test_handlers_run_while_it_computes(self):
        def handler(*_):
            raise Alarm

        self.addCleanup(signal.signal, signal.SIGALRM, signal.signal(signal.SIGALRM, handler))
        begin = time.monotonic()
        whole = self.denoiser.denoise(self.samples, threads=1)
        seconds = time.monotonic() - begin
        begin = time.monotonic()
        signal.setitimer(signal.ITIMER_REAL, seconds / 5)
        with self.assertRaises(Alarm):
            self.denoiser.denoise(self.samples, threads=1)
        self.assertLess(time.monotonic() - begin, 0.8 * seconds)
        np.testing.assert_array_equal(self.denoiser.denoise(self.samples, threads=1), whole)


class Threads(unittest.TestCase):
    def test_others_run_meanwhile(self):
        denoiser, samples = ld.Denoiser(), support.noisy_samples(256, 256, 4)
        done, turns = threading.Event(), []

        def take_turns():
            while not done.wait(0.002):
                turns.append(time.monotonic())

        other = threading.Thread(target=take_turns)
        other.start()
        begin = time.monotonic()
        denoiser.denoise(samples, threads=1)
        end = time.monotonic()
        done.set()
        other.join()
        during = [turn for turn in turns if begin < turn < end]
        self.assertGreater(len(during), 5)

    def test_two_denoisers_in_two_threads(self):
        samples = [support.noisy_samples(40, 50, 3, seed=seed) for seed in (1, 2)]
        expected = [ld.Denoiser().denoise(frame, threads=1) for frame in samples]
        found = [None, None]

        def work(index):
            denoiser = ld.Denoiser()
            for _ in range(5):
                found[index] = denoiser.denoise(samples[index], threads=1)

        workers = [threading.Thread(target=work, args=(index,)) for index in range(2)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        for picture, wanted in zip(found, expected):
            np.testing.assert_array_equal(picture, wanted)

    def test_one_denoiser_in_two_threads_is_refused(self):
        denoiser, samples, errors = ld.Denoiser(), support.noisy_samples(32, 32, 2), []
        inside, leave = threading.Event(), threading.Event()

        def wait(share):
            inside.set()
            leave.wait(60)

        worker = threading.Thread(target=lambda: denoiser.denoise(samples, progress=wait))
        worker.start()
        self.assertTrue(inside.wait(60))
        try:
            denoiser.denoise(samples)
        except RuntimeError as error:
            errors.append(str(error))
        leave.set()
        worker.join()
        self.assertEqual(len(errors), 1)
        self.assertIn("a Denoiser for each thread", errors[0])


class Surface(unittest.TestCase):
    def test_says_what_it_reads(self):
        denoiser = ld.Denoiser()
        self.assertEqual(denoiser.features, {"radiance": 3, "normal": 3, "depth": 1, "albedo": 3, "specular": 3})
        self.assertEqual(denoiser.required, ["radiance"])
        self.assertEqual(len(ld.Denoiser(support.SAMPLE_WEIGHTS).required), 10)
        self.assertIn("common_fine", repr(denoiser))
        self.assertEqual(ld.released_weights(), ["common_fast", "common_fine", "common_small", "common_tiny", "history_fast", "means", "pyramid_fine"])
        self.assertRegex(ld.__version__, r"^\d+\.\d+\.\d+$")

    def test_everything_public_has_a_help_text(self):
        for name in ld.__all__:
            thing = getattr(ld, name)
            if name != "__version__":
                self.assertTrue(thing.__doc__, name)
                self.assertTrue(thing.__module__.startswith("layered_denoiser"), name)
        for name, thing in vars(ld.Denoiser).items():
            if not name.startswith("_"):
                self.assertTrue(thing.__doc__, name)

    def test_the_versions_are_one(self):
        from importlib.metadata import version

        self.assertEqual(version("layered_denoiser"), ld.__version__)


if __name__ == "__main__":
    unittest.main()
