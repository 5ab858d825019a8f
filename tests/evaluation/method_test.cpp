#include "evaluation/method.h"

#include <gtest/gtest.h>

#include "test_frames.h"

namespace ld {
namespace {

TEST(Method, ModelArgumentsSplitAtTheFirstEqualsSign) {
  const auto models = parse_model_arguments({"layer=out/best.safetensors", "two layers=a=b"});
  ASSERT_EQ(models.size(), 2U);
  EXPECT_EQ(models[0].name, "layer");
  EXPECT_EQ(models[0].file, "out/best.safetensors");
  EXPECT_EQ(models[1].name, "two layers");
  EXPECT_EQ(models[1].file, "a=b");
  EXPECT_TRUE(parse_model_arguments({}).empty());
}

TEST(Method, BadModelArgumentsAreUsageErrorsThatSayWhatWasExpected) {
  EXPECT_THROW(parse_model_arguments({"weights.safetensors"}), UsageError);
  EXPECT_NE(message_of([] { parse_model_arguments({"weights.safetensors"}); }).find("expected NAME=FILE"),
            std::string::npos);
  EXPECT_NE(message_of([] { parse_model_arguments({"layer="}); }).find("expected NAME=FILE"),
            std::string::npos);
  EXPECT_NE(message_of([] { parse_model_arguments({"=file"}); }).find("without a name"), std::string::npos);
  EXPECT_NE(message_of([] {
              parse_model_arguments({"a=1", "b=2", "a=3"});
            }).find("two methods are named 'a'"),
            std::string::npos);
  EXPECT_NE(message_of([] { parse_model_arguments({"a\nb=1"}); }).find("control character"),
            std::string::npos);
  for (const std::string& name : std::vector<std::string>{"noisy", "blur", "reference"}) {
    const std::string message = message_of([&] { parse_model_arguments({name + "=file"}); });
    EXPECT_NE(message.find("may not be named '" + name + "'"), std::string::npos) << message;
  }
}

TEST(Method, FoldersOfPicturesAreNamedLikeModels) {
  const auto folders = parse_named_arguments("--images", "oidn=out/oidn", {"oidn=a/b"});
  EXPECT_EQ(folders[0].name, "oidn");
  EXPECT_EQ(folders[0].file, "a/b");
  EXPECT_EQ(message_of([] { parse_named_arguments("--images", "oidn=out/oidn", {"oidn"}); }),
            "--images oidn: expected NAME=DIR, for instance oidn=out/oidn");
}

TEST(Method, ABaselineMustBeOneOfTheMethods) {
  const std::vector<Method> methods = {{"layer", nullptr}};
  for (const char* name : {"", "noisy", "blur", "layer"}) EXPECT_NO_THROW(check_baseline(name, methods));
  EXPECT_THROW(check_baseline("lair", methods), UsageError);
  EXPECT_NE(message_of([&] { check_baseline("lair", methods); }).find("there are noisy, blur, layer"),
            std::string::npos);
}

}  // namespace
}  // namespace ld
