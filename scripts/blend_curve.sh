#!/usr/bin/env bash
# Error against samples, with and without `ld_denoise --blend`, for three released networks and both filters:
#
#   scripts/blend_curve.sh [OUT]     (default: out/blend_curve)
#
# Renders six frames of 48x36 pixels with 4096 samples each and references of 16384, 1.8 GB, minutes on two cores; they are kept.
# Prints tables of the mean relMSE and SMAPE and writes them to OUT/table.md. Environment: BIN, default build/bin.
set -euo pipefail
cd "$(dirname "$0")/.."
bin=${BIN:-build/bin} out=${1:-out/blend_curve}
data=$out/data counts=(1 2 4 16 64 256 1024 4096)
"$bin/ld_render" --recipe data/recipes/quick.yaml --frames 59:65 --out "$data" 'resolution=[48,36]' spp=4096 reference_spp.test=16384 >&2
frames=("$data"/frame_??????.exr)

denoise() { # NAME SAMPLES OPTIONS...: pictures into OUT/pictures/NAME_SAMPLES
  local folder=$out/pictures/$1_$2
  mkdir -p "$folder"
  "$bin/ld_denoise" "${@:3}" --samples "$2" --float "${frames[@]}" --output "$folder" > "$out/denoise.log" 2>&1 || { cat "$out/denoise.log" >&2; exit 1; }
}

methods=(common_fast common_fine means eaw svgf)
for n in "${counts[@]}"; do
  images=()
  for name in "${methods[@]}"; do
    how=(--model "$name")
    case $name in eaw | svgf) how=(--filter "$name") ;; esac
    denoise "$name" "$n" "${how[@]}"
    images+=(--images "$name=$out/pictures/${name}_$n")
    if [ "$n" -gt 1 ]; then # halves need two samples
      denoise "$name+blend" "$n" "${how[@]}" --blend
      images+=(--images "$name+blend=$out/pictures/$name+blend_$n")
    fi
  done
  "$bin/ld_eval" --data "$data" --samples "$n" "${images[@]}" --report-frames 0 --out "$out/eval_$n" > "$out/eval_$n.txt" 2>&1 || { cat "$out/eval_$n.txt" >&2; exit 1; }
  echo "blend_curve: $n samples done" >&2
done
python3 - "$out" "${counts[@]}" <<'END' | tee "$out/table.md"
import json, sys

out, counts = sys.argv[1], sys.argv[2:]
tables = {n: json.load(open(f"{out}/eval_{n}/metrics.json"))["methods"] for n in counts}
for metric, title in (("relmse", "relMSE"), ("smape", "SMAPE")):
    print(f"| {title} at samples | " + " | ".join(counts) + " |\n| :--- |" + " ---: |" * len(counts))
    for name in tables[counts[-1]]:
        if name == "blur":
            continue
        row = [tables[n].get(name, tables[n].get(name.split("+")[0])) for n in counts]
        print(f"| {name} | " + " | ".join(f"{cell['mean'][metric]:.4f}" for cell in row) + " |")
    print()
END
