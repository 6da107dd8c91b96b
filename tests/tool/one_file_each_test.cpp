#include "tool/input_file.h"

#include <gtest/gtest.h>

#include "tests/input_error.h"
#include "tool/error.h"

namespace nlg {
namespace {

TEST(OneFileEach, TakesFilesOfDifferentThings) {
  OneFileEach files("--weights", "representation");
  EXPECT_NO_THROW(files.add("a", "mlp"));
  EXPECT_NO_THROW(files.add("b", "pf5"));
}

TEST(OneFileEach, NamesBothFilesOfOneThing) {
  OneFileEach files("--weights", "representation");
  files.add("a", "mlp");
  files.add("b", "pf5");
  EXPECT_EQ(errorOfCall<UsageError>([&] { files.add("c", "mlp"); }),
            "--weights: expected one file per representation, got two of mlp: a and c");
}

}  // namespace
}  // namespace nlg
