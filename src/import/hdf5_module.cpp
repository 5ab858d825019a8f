#include <algorithm>
#include <cerrno>
#include <cstring>

#include "core/error.h"
#include "core/module.h"
#include "frame/half_rows.h"
#include "import/hdf5_file.h"
#include "import/hdf5_handle.h"

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

/// HDF5 has a type of its own for sizes.
std::vector<hsize_t> sizes_of(const std::vector<uint64_t>& dimensions) {
  return {dimensions.begin(), dimensions.end()};
}

struct OpenData : Hdf5Data {
  Hdf5Handle handle;
  bool half_floats = false;  // of IEEE binary16, which frame/half_rows.h converts

  void read_frame(uint64_t frame, std::vector<float>& values) const override;
  void write_frame(uint64_t frame, const std::vector<float>& values) const override;
};

std::string shape_text(const std::vector<hsize_t>& dimensions) {
  std::string text;
  for (const hsize_t size : dimensions) text += (text.empty() ? "" : ", ") + std::to_string(size);
  return "[" + text + "]";
}

/// A file can declare what it does not hold.
void check_storage(const OpenData& data) {
  const std::vector<hsize_t> dimensions = sizes_of(data.dimensions);
  const hsize_t frames = dimensions[0];
  hsize_t values = 1;
  for (size_t i = 0; i < dimensions.size(); ++i) {
    if (dimensions[i] == 0 || (i > 0 && dimensions[i] > kMostValues / values))
      fail("{}: of the shape {}; expected every dimension to be at least 1 and no frame above {} numbers",
           data.where, shape_text(dimensions), kMostValues);
    if (i > 0) values *= dimensions[i];
  }
  const Hdf5Handle type(H5Dget_type(data.handle.get()), H5Tclose);
  const unsigned long long bytes = H5Dget_storage_size(data.handle.get()),
                           per_value = H5Tget_size(type.get());
  if (frames > kMostFrames || values * per_value / kBestRatio > bytes / frames)
    fail(
        "{}: declares {} numbers, but the file holds {} bytes of them; it is damaged or cut short: copy it "
        "again",
        data.where, shape_text(dimensions), bytes);
  const Hdf5Handle properties(H5Dget_create_plist(data.handle.get()), H5Pclose);
  if (H5Pget_layout(properties.get()) != H5D_CHUNKED) return;
  std::vector<hsize_t> chunk(dimensions.size());
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
Hdf5Handle select_frame(const OpenData& data, hsize_t frame) {
  Hdf5Handle space(H5Dget_space(data.handle.get()), H5Sclose);
  std::vector<hsize_t> start(data.dimensions.size(), 0), count = sizes_of(data.dimensions);
  start[0] = frame;
  count[0] = 1;
  H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr);
  return space;
}

void OpenData::read_frame(uint64_t frame, std::vector<float>& values) const {
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

void OpenData::write_frame(uint64_t frame, const std::vector<float>& values) const {
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

class OpenFile : public Hdf5File {
 public:
  OpenFile(std::string path, Hdf5Handle file) : path_(std::move(path)), file_(std::move(file)) {}
  void flush() const override;
  bool has(const std::string& name) const override;
  std::unique_ptr<Hdf5Data> data(const std::string& name, size_t rank) const override;
  std::unique_ptr<Hdf5Data> make(const std::string& name, const std::vector<uint64_t>& dimensions,
                                 bool full) const override;

 private:
  std::string path_;
  Hdf5Handle file_;
};

void OpenFile::flush() const {
  if (H5Fflush(file_.get(), H5F_SCOPE_LOCAL) < 0) fail("cannot write {}: {}", path_, std::strerror(errno));
}

bool OpenFile::has(const std::string& name) const {
  return H5Lexists(file_.get(), name.c_str(), H5P_DEFAULT) > 0;
}

std::unique_ptr<Hdf5Data> OpenFile::data(const std::string& name, size_t rank) const {
  auto result = std::make_unique<OpenData>();
  OpenData& data = *result;
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
  std::vector<hsize_t> sizes(rank);
  H5Sget_simple_extent_dims(space.get(), sizes.data(), nullptr);
  data.dimensions.assign(sizes.begin(), sizes.end());
  check_storage(data);
  return result;
}

std::unique_ptr<Hdf5Data> OpenFile::make(const std::string& name, const std::vector<uint64_t>& dimensions,
                                         bool full) const {
  auto result = std::make_unique<OpenData>();
  OpenData& data = *result;
  data.where = fmt::format("{}: data set '{}'", path_, name);
  data.dimensions = dimensions;
  data.half_floats = !full;
  const std::vector<hsize_t> sizes = sizes_of(dimensions);
  const Hdf5Handle space(H5Screate_simple(static_cast<int>(sizes.size()), sizes.data(), nullptr), H5Sclose);
  const Hdf5Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties.get(), false);  // the same data set gives the same bytes
  std::vector<hsize_t> chunk = sizes;
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
  return result;
}

class InstalledHdf5 : public Hdf5Library {
 public:
  std::unique_ptr<Hdf5File> open(const std::filesystem::path& path) const override {
    be_quiet();
    if (!std::filesystem::is_regular_file(path)) fail("{}: no such file", path.string());
    Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
    if (!file.ok()) fail("{}: no HDF5 file, or a damaged one; copy it again", path.string());
    return std::make_unique<OpenFile>(path.string(), std::move(file));
  }

  std::unique_ptr<Hdf5File> create(const std::filesystem::path& path) const override {
    be_quiet();
    Hdf5Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
    if (!file.ok()) fail("cannot make {}: {}", path.string(), std::strerror(errno));
    return std::make_unique<OpenFile>(path.string(), std::move(file));
  }
};

}  // namespace
}  // namespace ld

LD_MODULE(ld::Hdf5Library, ld::InstalledHdf5)
