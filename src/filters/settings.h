// Settings of the classical filters: the keys of --set. Defaults do not depend on the scene's scale.
#pragma once

#include <cstdint>
#include <string>

#include "core/config_visitor.h"
#include "sequence/reprojection.h"

namespace ld {

/// What both filters do before and after: S = (C - E) / A, the light without the surface's colour.
struct IlluminationSettings {
  bool demodulate = true;         // filter light without the colour of surfaces: textures stay
  bool per_sample = false;        // the mean of each sample's S instead of S of the means
  bool split = true;              // direct and indirect light apart, where a frame tells them
  std::string compress = "none";  // reinhard: c / (1 + c), less bright outliers, darker highlights
  double firefly_bound = 0;       // times the mean luminance of the eight pixels around; 0: any

  template <class Visitor>
  void visit(Visitor& v) {
    v.field("demodulate", demodulate);
    v.field("per_sample", per_sample);
    v.field("split", split);
    v.field("compress", compress, {"none", "reinhard"});
    v.field("firefly_bound", firefly_bound, at_least(0));
  }
};

/// Dammertz et al. 2010.
struct EawSettings {
  IlluminationSettings light;
  int64_t levels = 5;              // à-trous passes, each of twice the reach of the one before
  std::string kernel = "b3";       // gauss: deviation 1
  std::string range = "colour";    // luminance: |d| is the difference of luminances
  std::string place = "position";  // depth: |X_p - X_q| is the difference of depths
  double sigma_light = 64;         // exp(-|d|^2 / sigma)
  double sigma_normal = 0.5;       // exp(-|n_p - n_q|^2 / sigma)
  double sigma_place = 4;          // exp(-|X_p - X_q|^2 / sigma), lengths in tenths of the depth scale
  bool narrow = false;             // level k: sigma_light / 4^k, |n_p - n_q|^2 / 4^k

  template <class Visitor>
  void visit(Visitor& v) {
    light.visit(v);
    v.field("levels", levels, {1, 5});
    v.field("kernel", kernel, {"b3", "gauss"});
    v.field("range", range, {"colour", "luminance"});
    v.field("place", place, {"position", "depth"});
    v.field("sigma_light", sigma_light, {1e-12, 1e30});
    v.field("sigma_normal", sigma_normal, {1e-12, 1e30});
    v.field("sigma_place", sigma_place, {1e-12, 1e30});
    v.field("narrow", narrow);
  }
};

/// Schied et al. 2017.
struct SvgfSettings {
  IlluminationSettings light;
  int64_t levels = 5;            // à-trous passes, each of twice the reach; 0: accumulated light, unfiltered
  double alpha = 0.2;            // least share of the new frame in the colour
  double alpha_moments = 0.2;    // and in the moments
  int64_t longest_history = 32;  // frames
  int64_t feedback = 0;          // the level whose output is the next frame's history; -1: before the first
  double sigma_light = 4;        // in standard deviations
  std::string variance = "taps";    // behind a level: that of independent taps; moments: of filtered moments
  int64_t normal_squarings = 7;     // (n_p . n_q)^(2^7)
  double sigma_depth = 1;           // in differences that the slope of the surface explains
  std::string slope = "isotropic";  // the steeper direction counts for all; plane: each its own
  double depth_tolerance = 0.01;    // share of the depth that is no difference
  double history_depth =
      kReprojectionDepth;  // differences up to so many times the slope are the same surface
  double history_normal = kReprojectionNormal;  // least n . n'
  std::string antilag = "clip";   // history within mean +- clip_deviations of the 5x5 pixels now; none
  double clip_deviations = 0.25;  // of antilag; 0.2 is the standard error of the mean of 25 pixels
  double antialias = 0.1;  // share of the new frame in the picture behind the filter; 1: no antialiasing
  double antialias_deviations = 1;  // the history within mean +- so many deviations of the 3x3 pixels

  template <class Visitor>
  void visit(Visitor& v) {
    light.visit(v);
    v.field("levels", levels, {0, 5});
    v.field("alpha", alpha, {0, 1});
    v.field("alpha_moments", alpha_moments, {0, 1});
    v.field("longest_history", longest_history, {1, 65536});
    v.field("feedback", feedback, {-1, 4});
    v.field("sigma_light", sigma_light, {1e-6, 1e30});
    v.field("variance", variance, {"taps", "moments"});
    v.field("normal_squarings", normal_squarings, {0, 10});
    v.field("sigma_depth", sigma_depth, {1e-6, 1e30});
    v.field("slope", slope, {"plane", "isotropic"});
    v.field("depth_tolerance", depth_tolerance, {0, 1});
    v.field("history_depth", history_depth, {0, 1e30});
    v.field("history_normal", history_normal, {-1, 1});
    v.field("antilag", antilag, {"none", "clip"});
    v.field("clip_deviations", clip_deviations, {0, 1e6});
    v.field("antialias", antialias, {0, 1});
    v.field("antialias_deviations", antialias_deviations, {0, 1e6});
  }
};

}  // namespace ld
