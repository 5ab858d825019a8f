// Work in strips gives what work on the whole gives, by name.
#include "models/row_strips.h"

#include <gtest/gtest.h>

namespace ld {
namespace {

using torch::Tensor;

/// Of a network that has no use for one of its tensors.
struct StripParts {
  Tensor planes, masks, unused;
  friend std::vector<Tensor*> tensors_of(StripParts& p) { return {&p.planes, &p.unused, &p.masks}; }
};

class RowStrips : public ::testing::Test {
 protected:
  StripParts parts(int64_t begin, int64_t end) const {
    return {rows(planes_, begin, end), rows(masks_, begin, end), {}};
  }
  void expect_whole(const StripParts& found, int64_t begin, int64_t end, const std::string& what) const {
    EXPECT_TRUE(found.planes.equal(rows(planes_, begin, end))) << what;
    EXPECT_TRUE(found.masks.equal(rows(masks_, begin, end))) << what;
    EXPECT_FALSE(found.unused.defined()) << what;
  }

  static constexpr int64_t kHeight = 13;
  Tensor planes_ = at::arange(2 * 3 * kHeight * 5, at::kFloat).view({2, 3, kHeight, 5});
  Tensor masks_ = at::arange(4 * kHeight * 2, at::kLong).view({1, 2, 2, kHeight, 2});
};

TEST_F(RowStrips, ArePutTogetherByName) {
  for (const int64_t step : {1, 4, 13, 20})
    for (const int64_t first : {0, 3})
      expect_whole(in_strips(first, kHeight, step, [&](int64_t b, int64_t e) { return parts(b, e); }), first,
                   kHeight, "step " + std::to_string(step));
}

TEST_F(RowStrips, KeepTheFormatOfAPicture) {
  const Tensor last = planes_.contiguous(at::MemoryFormat::ChannelsLast);
  const Tensor found = in_strips(kHeight, 4, [&](int64_t b, int64_t e) {
    return rows(last, b, e).contiguous(at::MemoryFormat::ChannelsLast);
  });
  EXPECT_TRUE(found.equal(planes_));
  EXPECT_EQ(found.suggest_memory_format(), at::MemoryFormat::ChannelsLast);
}

TEST_F(RowStrips, ThatReachMakeEachRowOnce) {
  for (const int64_t reach : {0, 1, 5, 40}) {
    const std::string what = "reach " + std::to_string(reach);
    int64_t made = 0;
    const StripParts found = in_reaching_strips(
        kHeight, 4, reach,
        [&](int64_t begin, int64_t end) {
          EXPECT_EQ(begin, made) << what;
          made = end;
          return parts(begin, end);
        },
        [&](const StripParts& given, int64_t first, int64_t begin, int64_t end) {
          const int64_t last = std::min(end + reach, kHeight);
          EXPECT_EQ(first, std::max<int64_t>(begin - reach, 0)) << what;
          expect_whole(given, first, last, what);
          return rows_of(given, begin - first, end - first);
        });
    EXPECT_EQ(made, kHeight) << what;
    expect_whole(found, 0, kHeight, what);
  }
}

TEST_F(RowStrips, AreStacked) {
  expect_whole(stacked_rows<StripParts>({parts(0, 5), parts(5, 6), parts(6, kHeight)}), 0, kHeight, "three");
  expect_whole(stacked_rows<StripParts>({parts(2, 7)}), 2, 7, "one");
}

}  // namespace
}  // namespace ld
