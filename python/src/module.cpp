// The extension module layered_denoiser._native. The package's Python files check what users pass and call
// this.
#include <nanobind/nanobind.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "core/error.h"
#include "frame/schema.h"
#include "frames.h"
#include "python_denoiser.h"
#include "weights/released.h"
#include "weights/weight_file.h"

namespace nb = nanobind;

// Other errors of ours are std::runtime_error, which is RuntimeError without a word.
NB_MODULE(_native, module) {
  nb::exception<ld::Cancelled>(module, "Cancelled", PyExc_RuntimeError);
  nb::register_exception_translator([](const std::exception_ptr& thrown, void*) {
    try {
      std::rethrow_exception(thrown);
    } catch (const ld::UsageError& error) {
      PyErr_SetString(PyExc_ValueError, error.what());
    }
  });

  module.attr("version") = LD_VERSION;
  module.def("feature_channels", [](const std::string& name) { return ld::find_feature(name).channels; });
  module.def("keep_released_models_in",
             [](const std::string& folder) { ld::keep_released_models_in(folder); });
  module.def("released_models", ld::released_models);
  module.def("resolve_model", [](const std::string& model) { return ld::resolve_model(model).string(); });
  module.def("read_frame", ld::read_frame_arrays);
  module.def("read_image", ld::read_image_array);
  module.def("write_image", ld::write_image_array);

  nb::class_<ld::PythonDenoiser>(module, "Denoiser")
      .def(nb::init<const std::string&>(), nb::call_guard<nb::gil_scoped_release>())
      .def(nb::init<const std::string&, const std::vector<std::string>&>())
      .def_prop_ro("name", &ld::PythonDenoiser::name)
      .def_prop_ro("remembers", &ld::PythonDenoiser::remembers)
      .def("restart", &ld::PythonDenoiser::restart)
      .def_prop_ro("skipped", &ld::PythonDenoiser::skipped)
      .def_prop_ro("features", &ld::PythonDenoiser::features)
      .def_prop_ro("required", &ld::PythonDenoiser::required)
      .def(
          "denoise",
          [](ld::PythonDenoiser& self, const std::map<std::string, ld::SampleArray>& features,
             const std::vector<ld::SampleArray>& parts, const ld::AlphaArray& alpha,
             const ld::ValidArray& valid, float depth_scale, int threads, int64_t max_memory_mb,
             double skip_within, const nb::object& progress, const std::vector<float>& world_to_camera,
             const std::vector<float>& world_to_ndc) {
            return self.denoise(
                {features, parts, alpha, valid},
                {depth_scale, threads, max_memory_mb, skip_within, world_to_camera, world_to_ndc, progress});
          },
          nb::arg(), nb::arg(), nb::arg().none(), nb::arg().none(), nb::arg(), nb::arg(), nb::arg(),
          nb::arg(), nb::arg().none(), nb::arg(), nb::arg());
}
