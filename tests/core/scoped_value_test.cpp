// A setting of a thread: it nests, is moved back, and other threads do not see it.
#include "core/scoped_value.h"

#include <gtest/gtest.h>

#include <string>
#include <thread>

namespace ld {
namespace {

class Word : public ScopedValue<Word, std::string> {
 public:
  using ScopedValue::ScopedValue;
  static std::string outside() { return "none"; }
};

class Flag : public ScopedValue<Flag, bool> {
 public:
  using ScopedValue::ScopedValue;
};

TEST(ScopedValue, HoldsWhileTheScopeLivesAndNests) {
  EXPECT_EQ(Word::current(), "none");
  EXPECT_FALSE(Flag::current());
  {
    const Word first("first");
    const Flag flag(true);
    EXPECT_TRUE(Flag::current());
    {
      const Word second("second");
      EXPECT_EQ(Word::current(), "second");
    }
    EXPECT_EQ(Word::current(), "first");
  }
  EXPECT_EQ(Word::current(), "none");
  EXPECT_FALSE(Flag::current());
}

TEST(ScopedValue, IsOfItsThread) {
  const Word word("here");
  std::string there;
  std::thread([&] { there = Word::current(); }).join();
  EXPECT_EQ(there, "none");
}

}  // namespace
}  // namespace ld
