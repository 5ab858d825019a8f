#include "import/hdf5_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "core/error.h"
#include "frame/exr_check.h"
#include "frame/half_float.h"

namespace ld {
namespace {

constexpr hsize_t kMostFrames = 10'000'000;
constexpr hsize_t kMostValues = hsize_t{1} << 31;  // of a frame or a chunk
constexpr unsigned long long kBestRatio = 1100;    // of deflate, which ends at 1032

/// Errors are ours to report: HDF5 would print its stack.
void be_quiet() {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

/// IEEE binary16, which HDF5 1.10 has no name for; the same that h5py writes.
Hdf5Handle half_type() {
  Hdf5Handle type(H5Tcopy(H5T_IEEE_F32LE), H5Tclose);
  H5Tset_fields(type.get(), 15, 10, 5, 0, 10);
  H5Tset_size(type.get(), 2);
  H5Tset_ebias(type.get(), 15);
  return type;
}

/// In either byte order.
bool is_half(const Hdf5Handle& type) {
  const Hdf5Handle little = half_type(), big = half_type();
  H5Tset_order(big.get(), H5T_ORDER_BE);
  return H5Tequal(type.get(), little.get()) > 0 || H5Tequal(type.get(), big.get()) > 0;
}

std::string shape_text(const std::vector<hsize_t>& dimensions) {
  std::string text;
  for (const hsize_t size : dimensions) text += (text.empty() ? "" : ", ") + std::to_string(size);
  return "[" + text + "]";
}

/// A file can declare what it does not hold.
void check_storage(const Hdf5Data& data) {
  const hsize_t frames = data.dimensions[0];
  hsize_t values = 1;
  for (size_t i = 0; i < data.dimensions.size(); ++i) {
    if (data.dimensions[i] == 0 || (i > 0 && data.dimensions[i] > kMostValues / values))
      fail("{}: of the shape {}; expected every dimension to be at least 1 and no frame above {} numbers",
           data.where, shape_text(data.dimensions), kMostValues);
    if (i > 0) values *= data.dimensions[i];
  }
  const Hdf5Handle type(H5Dget_type(data.handle.get()), H5Tclose);
  const unsigned long long bytes = H5Dget_storage_size(data.handle.get()),
                           per_value = H5Tget_size(type.get());
  if (frames > kMostFrames || values * per_value / kBestRatio > bytes / frames)
    fail(
        "{}: declares {} numbers, but the file holds {} bytes of them; it is damaged or cut short: copy it "
        "again",
        data.where, shape_text(data.dimensions), bytes);
  const Hdf5Handle properties(H5Dget_create_plist(data.handle.get()), H5Pclose);
  if (H5Pget_layout(properties.get()) != H5D_CHUNKED) return;
  std::vector<hsize_t> chunk(data.dimensions.size());
  hsize_t chunk_values = 1;
  if (H5Pget_chunk(properties.get(), static_cast<int>(chunk.size()), chunk.data()) < 0)
    fail("{}: HDF5 cannot read its layout; the file is damaged", data.where);
  for (const hsize_t size : chunk) {
    if (size == 0 || size > kMostValues / chunk_values)
      fail("{}: in chunks of {}; expected at most {} numbers", data.where, shape_text(chunk), kMostValues);
    chunk_values *= size;
  }
}

/// The place of one frame in the file.
Hdf5Handle select_frame(const Hdf5Data& data, hsize_t frame) {
  Hdf5Handle space(H5Dget_space(data.handle.get()), H5Sclose);
  std::vector<hsize_t> start(data.dimensions.size(), 0), count = data.dimensions;
  start[0] = frame;
  count[0] = 1;
  H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr);
  return space;
}

}  // namespace

size_t Hdf5Data::frame_values() const {
  size_t values = 1;
  for (size_t i = 1; i < dimensions.size(); ++i) values *= dimensions[i];
  return values;
}

void Hdf5Data::read_frame(hsize_t frame, std::vector<float>& values) const {
  values.resize(frame_values());
  const hsize_t count = values.size();
  const Hdf5Handle memory(H5Screate_simple(1, &count, nullptr), H5Sclose), space = select_frame(*this, frame),
                                                                           half_memory = half_type();
  std::vector<half> halves(half_floats ? values.size() : 0);
  if (H5Dread(handle.get(), half_floats ? half_memory.get() : H5T_NATIVE_FLOAT, memory.get(), space.get(),
              H5P_DEFAULT, half_floats ? static_cast<void*>(halves.data()) : values.data()) < 0)
    fail("{}: HDF5 cannot read frame {}; the file is damaged or packed with a filter that is not installed",
         where, frame);
  std::copy(halves.begin(), halves.end(), values.begin());
}

void Hdf5Data::write_frame(hsize_t frame, const std::vector<float>& values) const {
  const hsize_t count = values.size();
  if (count != frame_values()) fail("{}: {} numbers for a frame; expected {}", where, count, frame_values());
  const Hdf5Handle memory(H5Screate_simple(1, &count, nullptr), H5Sclose), space = select_frame(*this, frame),
                                                                           half_memory = half_type();
  // HDF5's own conversion loses the carry of values just below a power of two: 0.9998 would become 0.5.
  std::vector<half> halves(half_floats ? values.size() : 0);
  if (half_floats) std::transform(values.begin(), values.end(), halves.begin(), to_half);
  if (H5Dwrite(handle.get(), half_floats ? half_memory.get() : H5T_NATIVE_FLOAT, memory.get(), space.get(),
               H5P_DEFAULT, half_floats ? static_cast<const void*>(halves.data()) : values.data()) < 0)
    fail("cannot write {}: {}", where, std::strerror(errno));
}

Hdf5File Hdf5File::open(const std::filesystem::path& path) {
  be_quiet();
  Hdf5File result;
  result.path_ = path.string();
  if (!std::filesystem::is_regular_file(path)) fail("{}: no such file", result.path_);
  result.file_ = Hdf5Handle(H5Fopen(result.path_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!result.file_.ok()) fail("{}: no HDF5 file, or a damaged one; copy it again", result.path_);
  return result;
}

Hdf5File Hdf5File::create(const std::filesystem::path& path) {
  be_quiet();
  Hdf5File result;
  result.path_ = path.string();
  result.file_ =
      Hdf5Handle(H5Fcreate(result.path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
  if (!result.file_.ok()) fail("cannot make {}: {}", result.path_, std::strerror(errno));
  return result;
}

void Hdf5File::flush() const {
  if (H5Fflush(file_.get(), H5F_SCOPE_LOCAL) < 0) fail("cannot write {}: {}", path_, std::strerror(errno));
}

bool Hdf5File::has(const std::string& name) const {
  return H5Lexists(file_.get(), name.c_str(), H5P_DEFAULT) > 0;
}

Hdf5Data Hdf5File::data(const std::string& name, size_t rank) const {
  Hdf5Data data;
  data.where = fmt::format("{}: data set '{}'", path_, name);
  if (!has(name)) fail("{} is missing; expected the layout that docs/import.md describes", data.where);
  data.handle = Hdf5Handle(H5Dopen2(file_.get(), name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!data.handle.ok()) fail("{}: HDF5 cannot open it; it is a group, or the file is damaged", data.where);
  const Hdf5Handle type(H5Dget_type(data.handle.get()), H5Tclose);
  if (H5Tget_class(type.get()) != H5T_FLOAT)
    fail("{}: holds no floats; expected float16 or float32", data.where);
  data.half_floats = is_half(type);
  const Hdf5Handle space(H5Dget_space(data.handle.get()), H5Sclose);
  const int found = H5Sget_simple_extent_ndims(space.get());
  if (found != static_cast<int>(rank)) fail("{}: {} dimensions; expected {}", data.where, found, rank);
  data.dimensions.resize(rank);
  H5Sget_simple_extent_dims(space.get(), data.dimensions.data(), nullptr);
  check_storage(data);
  return data;
}

Hdf5Data Hdf5File::make(const std::string& name, const std::vector<hsize_t>& dimensions, bool full) const {
  Hdf5Data data;
  data.where = fmt::format("{}: data set '{}'", path_, name);
  data.dimensions = dimensions;
  data.half_floats = !full;
  const Hdf5Handle space(H5Screate_simple(static_cast<int>(dimensions.size()), dimensions.data(), nullptr),
                         H5Sclose);
  const Hdf5Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties.get(), false);  // the same data set gives the same bytes
  std::vector<hsize_t> chunk = dimensions;
  for (size_t i = 0; i + 3 < chunk.size(); ++i) chunk[i] = 1;
  if (dimensions.size() > 3) {
    H5Pset_chunk(properties.get(), static_cast<int>(chunk.size()), chunk.data());
    H5Pset_shuffle(properties.get());
    H5Pset_deflate(properties.get(), 4);
  }
  const Hdf5Handle half = half_type();
  data.handle = Hdf5Handle(H5Dcreate2(file_.get(), name.c_str(), full ? H5T_IEEE_F32LE : half.get(),
                                      space.get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT),
                           H5Dclose);
  if (!data.handle.ok()) fail("cannot make {}: {}", data.where, std::strerror(errno));
  return data;
}

}  // namespace ld
