#include "render/shading/metals.h"

namespace ld {

const std::vector<Metal>& metals() {
  static const std::vector<Metal> table = {
      {"silver", {0.052F, 0.060F, 0.040F}, {4.41F, 3.59F, 2.65F}},
      {"aluminium", {1.49F, 0.96F, 0.62F}, {7.82F, 6.69F, 5.47F}},
      {"gold", {0.155F, 0.43F, 1.45F}, {3.60F, 2.46F, 1.88F}},
      {"copper", {0.213F, 1.04F, 1.17F}, {3.67F, 2.59F, 2.40F}},
      {"chromium", {3.11F, 3.18F, 2.32F}, {3.34F, 3.33F, 3.14F}},
      {"iron", {2.90F, 2.95F, 2.65F}, {3.05F, 2.93F, 2.81F}},
      {"nickel", {2.20F, 1.83F, 1.66F}, {4.12F, 3.43F, 2.69F}},
      {"titanium", {2.74F, 2.54F, 2.27F}, {3.80F, 3.43F, 3.04F}},
      {"platinum", {2.43F, 2.13F, 1.87F}, {4.38F, 3.72F, 3.15F}},
      {"tungsten", {3.70F, 3.50F, 3.31F}, {2.90F, 2.72F, 2.47F}},
  };
  return table;
}

}  // namespace ld
