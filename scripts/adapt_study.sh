#!/usr/bin/env bash
# What five minutes of adapting to a shot without references are worth (docs/training.md): four shots of 12 frames of 160x96 with 8 samples a pixel and
# wide lenses or moving things, two of ld_render's scenes, a glTF model and an animation of Blender Cycles. Frames 1, 4, 7 and 10 are kept apart.
#   scripts/adapt_study.sh [OUT [ld_train options]]     (default: out/adapt; NAME_SHOTS="turn gltf" takes some)
# Prints a table of the frames kept apart, with Open Image Denoise where out/peers/venv has it, and writes it to OUT/table.md. Needs the programs in
# build/bin/, Blender, Debian's assimp-testmodels and, to have the other denoiser, scripts/peers/setup.sh. Environment: INIT (released weights to
# begin with, default pyramid_fine), NAME_SHOTS, RUN (what the trainings are named by, default adapted), BIN.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-out/adapt} bin=${BIN:-build/bin} init=${INIT:-pyramid_fine} run=${RUN:-adapted}
[ $# -eq 0 ] || shift
shots=${NAME_SHOTS:-turn dolly gltf cycles}
python=out/peers/venv/bin/python
mkdir -p "$out"

# Adapting reads no references, so those of its frames are of few samples; those of the frames that are kept apart have a set of their own.
train_frames="0 2 3 5 6 8 9 11" test_frames="1 4 7 10"
render() { # NAME RECIPE WORDS...
  local frame
  for frame in $train_frames; do one_frame "$1" "$2" 8 "$frame" "${@:3}"; done
  for frame in $test_frames; do one_frame "$1_test" "$2" 2048 "$frame" "${@:3}"; done
}
one_frame() { # NAME RECIPE REFERENCE FRAME WORDS...
  "$bin/ld_render" --recipe "data/recipes/$2.yaml" --out "$out/$1" --frames "$4:$(($4 + 1))" 'resolution=[160,96]' spp=8 frames.train=12 \
    frames.validation=0 frames.test=0 reference_spp.train="$3" "${@:5}" >> "$out/render.log" 2>&1 || { tail -n 3 "$out/render.log" >&2; exit 1; }
}
make_cycles() {
  command -v blender > /dev/null || { echo "adapt_study.sh: found no blender; apt-get install blender" >&2; exit 1; }
  local renders=$out/cycles_renders set=() frame name folder where
  # It keeps what is there.
  blender -b -P scripts/peers/cycles_sequence.py -- "$renders" 12 8 160 96 2048 1 "${test_frames// /,}" > "$out/blender.log" 2>&1
  while read -r assignment; do set+=(--set "$assignment"); done < "$renders/mapping.txt"
  mkdir -p "$out/cycles"
  for frame in $train_frames $test_frames; do
    name=frame_$(printf %04d "$frame") folder=$renders/$(printf %04d "$frame")
    where=(--frame "$out/cycles/$name.exr")
    [[ " $test_frames " != *" $frame "* ]] || where=(--reference "$folder/reference.exr" --out "$out/cycles_test" --name "$name" --split train
      --sequence 0 --position "$frame")
    "$bin/ld_import" --preset cycles "${set[@]}" --camera "$folder/camera.yaml" "${where[@]}" \
      "$folder"/sample_*.exr > "$out/import.log" 2>&1 || { cat "$out/import.log" >&2; exit 1; }
  done
}
own=(seed=77 sequence.length=12 sequence.noise_instances=1 scenes.defocus=1 scenes.motion_blur=1)
for shot in $shots; do
  [ ! -e "$out/$shot/made" ] || continue
  case $shot in
    turn) render turn sequence_quick "${own[@]}" 'sequence.kinds=[turn]' scenes.indoor=1 ;;
    dolly) render dolly sequence_quick "${own[@]}" 'sequence.kinds=[dolly]' scenes.indoor=0 ;;
    gltf) render gltf quick scene_file.path=/usr/share/assimp/models/glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb max_bounces=5 ;;
    cycles) make_cycles ;;
    *) echo "adapt_study.sh: no shot is named $shot; there are turn, dolly, gltf and cycles" >&2; exit 2 ;;
  esac
  touch "$out/$shot/made"
done

for shot in $shots; do
  if [ ! -e "$out/$run/$shot/done" ]; then
    mkdir -p "$out/$run/$shot"
    "$bin/ld_train" --config configs/adapt.yaml init="$init" data.path="$out/$shot" --out "$out/$run/$shot" "$@" > "$out/$run/$shot.log" 2>&1 ||
      { tail -n 3 "$out/$run/$shot.log" >&2; exit 1; }
    touch "$out/$run/$shot/done"
  fi
  others=()
  if [ -x "$python" ]; then
    [ -e "$out/oidn_$shot" ] || "$python" scripts/peers/oidn_denoise.py --data "$out/${shot}_test" --split train --samples 8 --out "$out/oidn_$shot" >&2
    others=(--images oidn="$out/oidn_$shot")
  fi
  "$bin/ld_eval" --data "$out/${shot}_test" --split train --model released="models/pretrained/$init.safetensors" --model adapted="$out/$run/$shot" "${others[@]}" \
    --baseline released --report-frames 4 --out "$out/$run/eval_$shot" > "$out/$run/eval_$shot.txt"
done
python3 - "$out" "$run" $shots <<'END' | tee "$out/$run/table.md"
import json, re, sys

out, run, shots = sys.argv[1], sys.argv[2], sys.argv[3:]
names = {"relmse": 4, "smape": 4, "psnr": 2}
print("| shot | method | relMSE | SMAPE | PSNR | relMSE below Open Image Denoise's | what the trainer said |\n| :--- | :--- | ---: | ---: | ---: | ---: | :--- |")
for shot in shots:
    found = json.load(open(f"{out}/{run}/eval_{shot}/metrics.json"))
    methods = found["methods"]
    def of_frames(method):
        return {f["name"]: f["relmse"] for f in methods[method]["frames"]}
    said = open(f"{out}/{run}/{shot}.log").read().strip().splitlines()[-1]
    for method in ("noisy", "oidn", "released", "adapted"):
        if method not in methods: continue
        mean = methods[method]["mean"]
        below = "-"
        if "oidn" in methods and method in ("released", "adapted"):
            own, other = of_frames(method), of_frames("oidn")
            below = f"{sum(own[f] < other[f] for f in own)} of {len(own)}"
        print(f"| {shot} | {method} | " + " | ".join(f"{mean[n]:.{d}f}" for n, d in names.items()) + f" | {below} | {said if method == 'adapted' else ''} |")
END
