// What a system has besides files.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

#include "runtime_eval/weights_file/weights_file.h"

namespace nlg {
namespace {

// A pipe would keep the reader waiting for ever.
TEST(WeightsReader, OpensRegularFilesOnly) {
  const std::string path = (std::filesystem::temp_directory_path() / ("nlg_weights_pipe_" + std::to_string(::getpid()))).string();
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  WeightsFile file;
  for (const auto& [name, what] :
       {std::pair<std::string, std::string>(path, "a pipe"), {"/tmp", "a directory"}, {"/dev/zero", "a device"}}) {
    const FileResult result = readWeightsFile(name, &file);
    EXPECT_EQ(result.status, FileStatus::cannot_open);
    EXPECT_EQ(result.detail, name + ": " + what);
  }
  std::filesystem::remove(path);
}

// A file of holes costs no disk, and must cost no memory.
TEST(WeightsReader, RefusesWhatIsTooLargeBeforeItTakesMemory) {
  const std::string path =
      (std::filesystem::temp_directory_path() / ("nlg_weights_holes_" + std::to_string(::getpid()))).string();
  std::ofstream(path, std::ios::binary) << "begins";
  std::filesystem::resize_file(path, uint64_t{1} << 40);
  WeightsFile file;
  EXPECT_EQ(readWeightsFile(path, &file).status, FileStatus::cannot_read);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace nlg
