#!/usr/bin/env bash
# Runs what works with other programs, small: data sets by Blender Cycles and by Mitsuba 3, trained on and evaluated; the comparison
# of renderers at a low resolution; exported networks in onnxruntime; Open Image Denoise beside a network of ours; event files in
# TensorBoard's reader; the Python package; processes that train together, started by mpirun, Slurm and torchrun. Installs them on first use
# (scripts/peers/setup.sh: 1.4 GB from PyPI and, where they are missing, Debian's python3-venv and libraries; scripts/peers/launchers.sh:
# Open MPI and Slurm from Debian, 3 GB with PyTorch from PyPI). scripts/test.sh does not need any of this. Everything lands in
# out/peers/test/ and out/peers/launchers/.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/peers/setup.sh
export OMP_WAIT_POLICY=passive
python=out/peers/venv/bin/python
out=out/peers/test
rm -rf $out
mkdir -p $out
SECONDS=0
step() { printf '\n== %s (%d min %02d s since the start)\n' "$1" $((SECONDS / 60)) $((SECONDS % 60)); }
small=(--width 96 --height 96 --spp 4 --reference-spp 128 --train 40)

# The table must hold the trained model beside the noisy input, all finite.
check() {
  "$python" - "$1" <<'END'
import json, math, sys
folder = sys.argv[1]
manifest = json.load(open(f"{folder}/manifest.json"))
splits = {frame["split"] for frame in manifest["frames"]}
assert splits == {"train", "validation", "test"}, splits
text = open(f"{folder}.eval/metrics.csv").read()
print(text)
assert "quick" in text and "noisy" in text and "nan" not in text.lower(), "the table lacks a row or has NaN"
END
}

step "1/9 Blender Cycles: a .blend file to a data set, training, evaluation"
"$python" scripts/peers/blender_dataset.py --out $out/blender --frames 4 "${small[@]}"
check $out/blender

step "2/9 Mitsuba 3: a scene to a data set, training, evaluation"
"$python" scripts/peers/mitsuba_dataset.py --out $out/mitsuba --views 4 "${small[@]}"
check $out/mitsuba

step "3/9 The renderers compared: small and noisy, so only a gross difference shows"
"$python" scripts/peers/compare_renderers.py --out $out/compare --size 48 --spp 256 --limit 5
step "4/9 Exported networks in onnxruntime: every network of the registry, three sizes"
"$python" scripts/peers/check_onnx.py --out $out/onnx

step "5/9 Open Image Denoise on the same frames, beside the network trained on them"
"$python" scripts/peers/oidn_denoise.py --data $out/blender --out $out/oidn --repeats 1
build/bin/ld_bench tradeoff --data $out/blender --model "quick=$out/blender.run" --images "oidn=$out/oidn" --repeats 1 --out $out/tradeoff
grep -q '^| oidn' $out/tradeoff/tradeoff.md

step "6/9 Event files in TensorBoard's own reader"
"$python" scripts/peers/read_tensorboard.py $out/blender.run
step "7/9 The Blender extension: installed, a still, an animation, cancelled"
"$python" scripts/peers/check_blender_extension.py --program build/bin/ld_denoise --out $out/extension | tail -n 1
step "8/9 The Python package: built by pip, its tests, the example of its page, and its speed beside Open Image Denoise"
scripts/peers/python_package.sh
"$python" -B -m unittest discover python/tests
"$python" scripts/peers/speed.py --frame "$(ls $out/blender/*.exr | grep -v reference | head -n 1)" --sizes 24x40,64x64 --repeats 2 --json $out/speed.json
step "9/9 Two processes by mpirun, Slurm and torchrun: their bits, and what is left when one is killed"
scripts/peers/launchers.sh
step "Done: data sets, comparisons, ONNX, Open Image Denoise, TensorBoard, the extension, the Python package and the launchers passed"
