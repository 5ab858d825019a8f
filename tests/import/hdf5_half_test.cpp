// Half floats in HDF5 files are what their bits say, and floats become the nearest of them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "import/hdf5_file.h"
#include "import/hdf5_handle.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

/// A file with one row of numbers as half floats, whose bits are read back with HDF5's own type.
std::vector<uint16_t> written_bits(const fs::path& path, const std::vector<float>& values) {
  Hdf5File::create(path)->make("row", {1, values.size()})->write_frame(0, values);
  std::vector<uint16_t> bits(values.size());
  const Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose),
      data(H5Dopen2(file.get(), "row", H5P_DEFAULT), H5Dclose), type(H5Dget_type(data.get()), H5Tclose);
  EXPECT_GE(H5Dread(data.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, bits.data()), 0);
  return bits;
}

/// By its definition: sign, five bits of exponent, ten of mantissa.
double half_value(uint16_t bits) {
  const int exponent = bits >> 10 & 31;
  const double mantissa = bits & 1023;
  const double size = exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25);
  return bits >> 15 != 0 ? -size : size;
}

bool finite_half(uint16_t bits) {
  return (bits & 0x7c00) != 0x7c00;
}

TEST(Hdf5, EveryHalfFloatSurvivesBothWays) {
  const TemporaryFolder folder;
  std::vector<uint16_t> all(65536);
  std::iota(all.begin(), all.end(), uint16_t{0});
  const fs::path path = folder / "halves.h5";
  std::vector<float> values;
  for (const uint16_t bits : all)
    values.push_back(finite_half(bits) ? static_cast<float>(half_value(bits)) : 0);
  const std::vector<uint16_t> written = written_bits(path, values);
  for (const uint16_t bits : all)
    if (finite_half(bits)) {
      ASSERT_EQ(written[bits], bits) << values[bits];
    }

  // Infinities and NaN too, and files in the other byte order.
  for (const H5T_order_t order : {H5T_ORDER_LE, H5T_ORDER_BE}) {
    {
      const Hdf5Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
      Hdf5File::create(folder / "like.h5")->make("row", {1, 1});
      const Hdf5Handle like(H5Fopen((folder / "like.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose),
          row(H5Dopen2(like.get(), "row", H5P_DEFAULT), H5Dclose),
          type(H5Tcopy(Hdf5Handle(H5Dget_type(row.get()), H5Tclose).get()), H5Tclose),
          memory(H5Tcopy(type.get()), H5Tclose);
      H5Tset_order(type.get(), order);
      const hsize_t size[] = {1, 65536};
      const Hdf5Handle space(H5Screate_simple(2, size, nullptr), H5Sclose);
      const Hdf5Handle data(
          H5Dcreate2(file.get(), "row", type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
          H5Dclose);
      ASSERT_GE(H5Dwrite(data.get(), memory.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()), 0);
    }
    Hdf5File::open(path)->data("row", 2)->read_frame(0, values);
    for (const uint16_t bits : all) {
      if (finite_half(bits)) {
        ASSERT_EQ(values[bits], static_cast<float>(half_value(bits))) << "bits " << bits;
        ASSERT_EQ(std::signbit(values[bits]), bits >> 15 != 0) << "bits " << bits;
      } else {
        ASSERT_EQ(std::isinf(values[bits]), (bits & 1023) == 0) << "bits " << bits;
        ASSERT_EQ(std::isnan(values[bits]), (bits & 1023) != 0) << "bits " << bits;
      }
    }
  }
}

TEST(Hdf5, BetweenTwoHalfFloatsTheNearestIsWrittenAndTiesGoToTheEvenOne) {
  const TemporaryFolder folder;
  std::vector<float> values;
  std::vector<uint16_t> expected;
  for (uint16_t low = 0; low < 0x7bff; ++low) {  // both neighbours finite
    const auto high = static_cast<uint16_t>(low + 1);
    const auto middle = static_cast<float>(0.5 * (half_value(low) + half_value(high)));
    for (const float sign : {1.0F, -1.0F}) {
      const auto signed_bits = [&](uint16_t bits) {
        return static_cast<uint16_t>(bits | (sign < 0 ? 0x8000 : 0));
      };
      values.push_back(sign * std::nextafter(middle, 0.0F));
      expected.push_back(signed_bits(low));
      values.push_back(sign * middle);
      expected.push_back(signed_bits(low % 2 == 0 ? low : high));
      values.push_back(sign * std::nextafter(middle, 1e6F));
      expected.push_back(signed_bits(high));
    }
  }
  const std::vector<uint16_t> found = written_bits(folder / "middles.h5", values);
  for (size_t i = 0; i < values.size(); ++i)
    ASSERT_EQ(found[i], expected[i]) << fmt::format("{:a}", values[i]);
  // Beyond the largest one the largest; NaN marks samples that were not drawn.
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<uint16_t> ends = written_bits(folder / "ends.h5", {65519, 65520, 1e30F, -1e30F, nan});
  EXPECT_EQ(std::vector<uint16_t>(ends.begin(), ends.end() - 1),
            (std::vector<uint16_t>{0x7bff, 0x7bff, 0x7bff, 0xfbff}));
  EXPECT_FALSE(finite_half(ends[4]));
}

}  // namespace
}  // namespace ld
