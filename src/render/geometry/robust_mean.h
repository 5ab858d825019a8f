// Means of independent estimates of one pixel that a few outliers cannot spoil.
#pragma once

#include <array>
#include <vector>

namespace ld {

using Radiance = std::array<double, 3>;  // linear R, G, B, at least 0

Radiance plain_mean(const std::vector<Radiance>& estimates);

/// Gini coefficient of numbers of at least 0 in ascending order, in [0, 1 - 1 / n]: 0 when all are equal or
/// none is above 0, its maximum when all but one are 0. Of normal noise of relative deviation d about 0.56 d.
double gini_coefficient(const std::vector<double>& ascending);

/// The adaptive median of means of Buisine, Delepoulle and Renaud ("Firefly removal in Monte Carlo rendering
/// with adaptive median of means", EGSR 2021): of n estimates, ordered by the sum of their channels, the
/// lowest and the highest floor(G n / 2) are left out and the others averaged, G being the Gini coefficient
/// of the sums. While G is below 2 / n all are kept: the plain mean. Where one outlier holds nearly
/// everything, one or two in the middle are: the median. Whole estimates are kept or left out, so that hues
/// stay.
///
/// It is no unbiased estimate while outliers are still rare: what few of the estimates have seen is lost.
/// With more samples an estimate G falls, and it becomes the mean. NaN or infinite estimates: the plain mean,
/// so that the fault stays visible. `estimates` must not be empty.
Radiance robust_mean(std::vector<Radiance> estimates);

}  // namespace ld
